/* Accuracy of broadcast orbits: index, as satellites send it, against metres, as RINEX has it. */
#ifndef FURROW_FORMATS_RINEX_ACCURACY_H
#define FURROW_FORMATS_RINEX_ACCURACY_H

/* URA of GPS, QZSS, BeiDou and SBAS: the index (0..15) whose range a value [m] lies in; 15 for anything
 * larger, and for what is no accuracy. And the nominal value of an index [m]; 8192 for 15 and what is no
 * index. Source: IS-GPS-200N, 20.3.3.3.1.3. */
int fw_ura_index(double ura_m);
double fw_ura_m(int index);

/* SISA of Galileo: the index (0..125) of a value [m]; -1 for "no accuracy prediction available". And the
 * value of an index, -1 for an index that has none. Source: Galileo OS SIS ICD 2.1, table 89. */
int fw_sisa_index(double sisa_m);
double fw_sisa_m(int index);

#endif
