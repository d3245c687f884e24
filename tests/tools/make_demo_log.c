/* Makes testdata/demo.sbf: what a receiver on the drone of demo_scene.h would log in a minute, written by furrow's own
 * encoders. Same program, same bytes.
 *
 * usage: make_demo_log > demo.sbf */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/frame.h"
#include "base/matrix.h"
#include "base/random.h"
#include "base/time.h"
#include "demo_lnav.h"
#include "demo_scene.h"
#include "formats/bytes.h"
#include "formats/sbas_message.h"
#include "formats/sbf_codec.h"
#include "formats/sbf_measurements.h"
#include "formats/sbf_signal.h"
#include "furrow_eph_sbas.h"
#include "furrow_obs_columns.h"
#include "furrow_sbas_almanac.h"
#include "furrow_sbas_degradation.h"
#include "furrow_sbas_factors.h"
#include "furrow_sbas_fast.h"
#include "furrow_sbas_igp_mask.h"
#include "furrow_sbas_integrity.h"
#include "furrow_sbas_iono.h"
#include "furrow_sbas_long.h"
#include "furrow_sbas_mask.h"
#include "furrow_sbas_service.h"
#include "furrow_sbas_time.h"

#define ABSENT     -2e10 /* do-not-use of f4 and f8 */
#define GEO        "S123"
#define LEAP_S     18 /* GPS minus UTC */
#define RANGE_SD_M 0.9

static scene_satellite sky[SCENE_SATELLITES];
static fw_random noise;

static void check(fw_status status, const char *what)
{
	if (status == FW_OK)
		return;
	fprintf(stderr, "make_demo_log: %s: %s\n", what, fw_status_text(status));
	exit(1);
}

static void write_bytes(const void *bytes, size_t n)
{
	if (fwrite(bytes, 1, n, stdout) != n)
		check(FW_EIO, "output");
}

/* So that the last bits of the C library's sines do not show. */
static double rounded(double x, double step)
{
	return nearbyint(x / step) * step;
}

static double normal(double sd)
{
	return sd * fw_random_normal(&noise);
}

/* ---- blocks by the names of their fields ---- */

/* The block being made, and the part of it that set() means: the fixed part, then the sub-block added last. */
static fw_sbf_values block;
static const fw_sbf_field *part;
static size_t part_fields, block_bytes;
static uint32_t part_first;

/* What a field holds before set(): do-not-use where the table knows of one, else 0. */
static int64_t unset(const fw_sbf_field *f)
{
	float single = (float)ABSENT;
	double full = ABSENT;
	uint32_t bits;
	int64_t wide;
	memcpy(&bits, &single, sizeof bits);
	memcpy(&wide, &full, sizeof wide);
	switch (f->type) {
	case SBF_F4: return bits;
	case SBF_F8: return wide;
	case SBF_I1: return f->dnu == SBF_DNU ? INT8_MIN : 0;
	case SBF_I2: return f->dnu == SBF_DNU ? INT16_MIN : 0;
	case SBF_I4: return f->dnu == SBF_DNU ? INT32_MIN : 0;
	default: return f->dnu == SBF_DNU ? (INT64_C(1) << 8 * fw_sbf_type_size(f->type)) - 1 : 0;
	}
}

static void add_part(const fw_sbf_field *fields, size_t n)
{
	part = fields;
	part_fields = n;
	part_first = block.n;
	for (size_t i = 0; i < n; i++) {
		if (fields[i].width > 0)
			continue;
		for (unsigned k = 0; k < fields[i].count; k++) {
			block.values[block.n++] = unset(&fields[i]);
			block_bytes += fw_sbf_type_size(fields[i].type);
		}
	}
}

static void begin(const char *name, int64_t ms)
{
	int i = 0;
	while (i < fw_sbf_n_schemas && strcmp(fw_sbf_schemas[i].name, name) != 0)
		i++;
	if (i == fw_sbf_n_schemas)
		check(FW_EUNKNOWN, name);
	block.schema = &fw_sbf_schemas[i];
	block.revision = block.schema->revision;
	block.tow_ms = (uint32_t)(SCENE_START_S * INT64_C(1000) + ms);
	block.week = SCENE_WEEK;
	block.n = 0;
	block_bytes = FW_SBF_BODY;
	add_part(block.schema->fields, block.schema->n_fields);
}

/* The next sub-block, of the group of that number. */
static void add(unsigned group)
{
	const fw_sbf_group *g = &block.schema->groups[group];
	add_part(g->fields, g->n_fields);
}

/* Element k of a field, as the raw number of the wire. */
static void set_at(const char *name, unsigned k, double raw)
{
	uint32_t at = part_first;
	const fw_sbf_field *f = part;
	for (; f < part + part_fields && (f->width > 0 || strcmp(f->name, name) != 0); f++)
		at += f->width > 0 ? 0 : f->count;
	if (f == part + part_fields || k >= f->count)
		check(FW_EUNKNOWN, name);
	uint32_t bits;
	float single = (float)raw;
	memcpy(&bits, &single, sizeof bits);
	block.values[at + k] = llround(f->type == SBF_F4 || f->type == SBF_F8 ? 0 : raw);
	if (f->type == SBF_F4)
		block.values[at + k] = bits;
	if (f->type == SBF_F8)
		memcpy(&block.values[at + k], &raw, sizeof raw);
}

static void set(const char *name, double raw)
{
	set_at(name, 0, raw);
}

static void set_text(const char *name, const char *text)
{
	for (unsigned k = 0; text[k] != '\0'; k++)
		set_at(name, k, text[k]);
}

/* Fields in the order of the names, which blanks separate. */
static void set_all(const char *names, const double *raw)
{
	char name[32];
	for (int i = 0; *names != '\0'; i++) {
		size_t n = strcspn(names, " ");
		snprintf(name, sizeof name, "%.*s", (int)n, names);
		set(name, raw[i]);
		names += n + (names[n] == ' ');
	}
}

static void end(void)
{
	static uint8_t bytes[FW_SBF_MAX_LENGTH];
	for (; block_bytes % 4 != 0; block_bytes++)
		block.values[block.n++] = 0;
	block.length = (uint16_t)block_bytes;
	check(fw_sbf_encode(&block, bytes), block.schema->name);
	write_bytes(bytes, block.length);
}

static void marker(const char *name, int64_t ms)
{
	begin(name, ms);
	end();
}

/* ---- measurements ---- */

/* Vertical delay through the ionosphere at L1, and how much more at a low elevation and another frequency. */
static double iono_m(const scene_view *view, double frequency_hz)
{
	double at_shell = 0.947 * cos(view->elevation_rad), l1_per_f = 1575.42e6 / frequency_hz;
	return 1.8 / sqrt(1 - at_shell * at_shell) * l1_per_f * l1_per_f;
}

static furrow_obs observe(const scene_satellite *s, unsigned channel, const scene_view *view, int second,
                          double clock_m, unsigned which)
{
	const fw_sbf_signal *signal = fw_sbf_signal_of(s->signals[which]);
	double frequency_hz = signal->frequency_hz + s->channel * signal->channel_spacing_hz;
	double wave_m = SCENE_LIGHT_MPS / frequency_hz, iono = iono_m(view, frequency_hz);
	double without_iono = view->range_m + clock_m + 2.4 / sin(view->elevation_rad);
	double ambiguity = 100 * (double)channel - 700 + 13 * which;
	furrow_obs o = {.sat = (char *)(uintptr_t)s->name, .signal = (char *)(uintptr_t)signal->rinex};
	o.glonass_channel = (int8_t)s->channel;
	o.pseudorange_m = without_iono + iono + normal(0.25);
	o.carrier_cyc = (without_iono - iono) / wave_m + ambiguity + normal(0.004);
	o.doppler_hz = -(view->range_rate_mps + SCENE_LIGHT_MPS * SCENE_CLOCK_DRIFT) / wave_m + normal(0.03);
	o.cn0_dbhz = rounded(33 + 17 * sin(view->elevation_rad) - 3 * which + normal(0.4), 0.25);
	o.lock_s = 40 * (int)channel + second;
	o.rx_channel = (int16_t)channel;
	o.present = (INT64_C(1) << FW_COL_obs_COUNT) - 1;
	return o;
}

static void measurements(int second, double t, const scene_view views[static SCENE_SATELLITES])
{
	static uint8_t bytes[FW_SBF_MAX_LENGTH];
	furrow_obs obs[2 * SCENE_SATELLITES];
	uint16_t length;
	unsigned n = 0;
	furrow_epoch epoch = {.present = 3,
	                      .gps_week = SCENE_WEEK,
	                      .tow_s = SCENE_START_S + second,
	                      .multipath_mitigation = 1,
	                      .high_dynamics = 1};

	for (unsigned i = 0; i < SCENE_SATELLITES; i++)
		for (unsigned which = 0; which < 2; which++)
			obs[n++] = observe(&sky[i], i + 1, &views[i], second,
			                   SCENE_LIGHT_MPS * (scene_clock_s(t) - sky[i].clock_s), which);
	check(fw_sbf_encode_meas_epoch(&epoch, obs, n, bytes, &length), "MeasEpoch");
	write_bytes(bytes, length);
}

static void more_measurements(int second, const scene_view views[static SCENE_SATELLITES])
{
	begin("MeasExtra", second * 1000);
	set("N", 2 * SCENE_SATELLITES);
	set("SBLength", 16);
	set("DopplerVarFactor", 3.1);
	for (unsigned i = 0; i < 2 * SCENE_SATELLITES; i++) {
		double low = 1 / sin(views[i / 2].elevation_rad);
		add(0);
		set("RxChannel", i / 2 + 1);
		set("Type", sky[i / 2].signals[i % 2]);
		set("MPCorrection", normal(120));
		set("CodeVar", 400 * low);
		set("CarrierVar", 12 * low);
		set("LockTime", 40 * (i / 2 + 1) + (unsigned)second);
		set("CarMPCorr", normal(2));
		set("Misc", (double)fw_random_below(&noise, 8));
	}
	end();
}

/* ---- the receiver's solution ---- */

typedef struct {
	int n;          /* satellites used; 0: no solution */
	double Q[4][4]; /* north, east, up, clock: covariance for ranges of 1 m */
	double error_n[3];
} solution;

static int usable(const scene_satellite *s, int second)
{
	return second >= s->usable_s;
}

static solution solve(int second, const scene_view views[static SCENE_SATELLITES])
{
	solution s = {0};
	double N[16] = {0};
	for (int i = 0; i < SCENE_SATELLITES; i++) {
		double h[4] = {-views[i].sight_n[0], -views[i].sight_n[1], views[i].sight_n[2], 1};
		if (!usable(&sky[i], second))
			continue;
		s.n++;
		for (int k = 0; k < 16; k++)
			N[k] += h[k / 4] * h[k % 4];
	}
	if (s.n == 0)
		return s;
	check(fw_mat_inverse_spd(4, N, &s.Q[0][0]), "geometry");
	s.error_n[0] = 0.31 * sin(0.05 * second) + normal(0.03);
	s.error_n[1] = 0.24 * cos(0.04 * second) + normal(0.03);
	s.error_n[2] = 0.52 * sin(0.03 * second + 1) + normal(0.06);
	return s;
}

static int mode_at(int second, const solution *s)
{
	return s->n == 0     ? 0
	       : second < 12 ? 1
	                     : 6; /* none; stand-alone; SBAS once its corrections are complete */
}

/* Mode and Error, with which several blocks begin. Returns whether there is a solution. */
static int begin_solution(const char *name, int second, const solution *s)
{
	begin(name, second * 1000);
	set("Mode", mode_at(second, s));
	set("Error", s->n > 0 ? 0 : 2); /* too few ephemerides */
	return s->n > 0;
}

static void position(int second, const scene_drone *d, const solution *s)
{
	if (begin_solution("PVTGeodetic", second, s)) {
		double cm_95 = RANGE_SD_M * 2 * 100; /* of range error, two sigma */
		set("Lat", rounded(d->llh[0] + s->error_n[0] / 6377000, 1e-11));
		set("Lon", rounded(d->llh[1] + s->error_n[1] / 3930000, 1e-11));
		set("Height", rounded(d->llh[2] - s->error_n[2], 1e-4));
		set("Undulation", 45.59);
		double vn = d->vel_n[0] + normal(0.02), ve = d->vel_n[1] + normal(0.02);
		set("Vn", vn);
		set("Ve", ve);
		set("Vu", -d->vel_n[2] + normal(0.04));
		set("COG", fw_deg_from_rad(fw_wrap_2pi(atan2(ve, vn))));
		set("RxClkBias", rounded(1e3 * scene_clock_s(SCENE_START_S + second) + normal(1e-6), 1e-9));
		set("RxClkDrift", SCENE_CLOCK_DRIFT * 1e6 + normal(1e-4));
		set("TimeSystem", 0);
		set("Datum", 0);
		set("NrSV", s->n);
		set("HAccuracy", cm_95 * sqrt(s->Q[0][0] + s->Q[1][1]));
		set("VAccuracy", cm_95 * sqrt(s->Q[2][2]));
		set("SignalInfo", 1 | 1 << 8 | 1 << 17 | 1 << 28);
		set("AlertFlag", 1);
		set("Latency", 180 + (double)fw_random_below(&noise, 20));
	}
	if (mode_at(second, s) == 6) {
		set("WACorrInfo", 7);
		set("ReferenceID", 123);
		set("MeanCorrAge", 280 + (double)fw_random_below(&noise, 250));
		set("NrBases", 1);
	}
	end();
}

/* The ten numbers of a covariance, scaled, in the order of the block. */
static void covariance(const char *name, int second, const solution *s, double scale, const char *names)
{
	static const uint8_t at[10][2] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {0, 1},
	                                  {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
	double raw[10];
	for (int i = 0; i < 10; i++)
		raw[i] = scale * s->Q[at[i][0]][at[i][1]];
	if (begin_solution(name, second, s))
		set_all(names, raw);
	end();
}

/* Protection levels: RTCA DO-229, J.2.1, with K_H 6.0 and K_V 5.33. */
static void dilution(int second, const solution *s)
{
	const double(*Q)[4] = s->Q;
	begin("DOP", second * 1000);
	if (s->n > 0) {
		double mean = (Q[0][0] + Q[1][1]) / 2, major = mean + hypot((Q[0][0] - Q[1][1]) / 2, Q[0][1]);
		set("NrSV", s->n);
		set("PDOP", 100 * sqrt(Q[0][0] + Q[1][1] + Q[2][2]));
		set("TDOP", 100 * sqrt(Q[3][3]));
		set("HDOP", 100 * sqrt(2 * mean));
		set("VDOP", 100 * sqrt(Q[2][2]));
		set("HPL", 6.0 * RANGE_SD_M * sqrt(major));
		set("VPL", 5.33 * RANGE_SD_M * sqrt(Q[2][2]));
	}
	end();
}

/* Two antennas along the drone's axis: heading and pitch, no roll. */
static void attitude(int second, const scene_drone *d, const solution *s)
{
	begin("AttEuler", second * 1000);
	set("Error", s->n > 0 ? 0 : 1);
	if (s->n > 0) {
		set("NrSV", s->n);
		set("Mode", 2);
		set("Heading", fw_deg_from_rad(fw_wrap_2pi(d->rpy[2] + normal(0.003))));
		set("Pitch", fw_deg_from_rad(d->rpy[1] + normal(0.005)));
		set("PitchDot", normal(0.05));
		set("HeadingDot", fw_deg_from_rad(d->rpy_rate[2]) + normal(0.05));
	}
	end();
	begin("AttCovEuler", second * 1000);
	set("Error", s->n > 0 ? 0 : 1);
	if (s->n > 0) {
		set("Cov_HeadHead", 0.0296);
		set("Cov_PitchPitch", 0.0821);
		set("Cov_HeadPitch", -0.0021);
	}
	end();
	marker("EndOfAtt", second * 1000);
}

static void inertial_solution(int second, const scene_drone *d, const solution *s)
{
	enum { POSITION_SD, ATTITUDE, ATTITUDE_SD, VELOCITY, VELOCITY_SD, PARTS };
	begin("INSNavGeod", second * 1000);
	set("GNSSMode", mode_at(second, s) | 2 << 4);
	set("Info", 1 | 1 << 6); /* loosely coupled, heading known */
	set("GNSSAge", 0);
	set("Latitude", rounded(d->llh[0] + 0.8 * s->error_n[0] / 6377000, 1e-11));
	set("Longitude", rounded(d->llh[1] + 0.8 * s->error_n[1] / 3930000, 1e-11));
	set("Height", rounded(d->llh[2] - 0.8 * s->error_n[2], 1e-4));
	set("Undulation", 45.59);
	set("Accuracy", 85);
	set("Latency", 120);
	set("Datum", 0);
	set("SBList", (1 << PARTS) - 1);
	add(POSITION_SD);
	set_all("LatitudeStdDev LongitudeStdDev HeightStdDev", (double[]){0.42, 0.37, 0.66});
	add(ATTITUDE);
	set("Heading", fw_deg_from_rad(fw_wrap_2pi(d->rpy[2] + normal(0.002))));
	set("Pitch", fw_deg_from_rad(d->rpy[1] + normal(0.0005)));
	set("Roll", fw_deg_from_rad(d->rpy[0] + normal(0.0005)));
	add(ATTITUDE_SD);
	set_all("HeadingStdDev PitchStdDev RollStdDev", (double[]){0.15, 0.031, 0.03});
	add(VELOCITY);
	set("Ve", d->vel_n[1] + normal(0.01));
	set("Vn", d->vel_n[0] + normal(0.01));
	set("Vu", -d->vel_n[2] + normal(0.02));
	add(VELOCITY_SD);
	set_all("VeStdDev VnStdDev VuStdDev", (double[]){0.011, 0.012, 0.018});
	end();
}

/* ---- the receiver itself ---- */

static void setup(void)
{
	const char *remark =
	    "Simulated: no receiver and no drone were involved. Part of furrow, testdata/demo.sbf.";
	begin("ReceiverSetup", 0);
	set_text("MarkerName", "FIELD-7");
	set_text("Observer", "furrow");
	set_text("Agency", "demo farm");
	set_text("RxSerialNbr", "0000001");
	set_text("RxName", "simulated");
	set_text("RxVersion", "0.1");
	set_text("AntType", "simulated, no radome");
	set_all("deltaH deltaE deltaN", (double[]){0, 0, 0});
	set_text("MarkerType", "NON_GEODETIC");
	set_text("ProductName", "make_demo_log");
	set_text("CountryCode", "DEU");
	end();
	begin("Comment", 0);
	set("CommentLn", (double)strlen(remark));
	for (const char *c = remark; *c != '\0'; c++) {
		add(0);
		set("Comment", *c);
	}
	end();
	begin("IMUSetup", 0);
	set("SerialPort", 2);
	set_all("AntLeverArmX AntLeverArmY AntLeverArmZ ThetaX ThetaY ThetaZ",
	        (double[]){0.08, 0, -0.21, 0, 0, 0});
	end();
}

static void clock_and_quality(int second, const solution *s)
{
	static const uint8_t quality[][2] = {
	    {0, 9}, {1, 9}, {2, 8}, {21, 10}}; /* overall, antennas, processor */
	fw_time now;
	fw_civil utc;
	check(fw_time_from_gps(SCENE_WEEK, (SCENE_START_S + second) * FW_NS_PER_S, &now), "time");
	check(fw_time_to_utc(now, &utc), "time");
	begin("ReceiverTime", second * 1000);
	set_all("UTCYear UTCMonth UTCDay UTCHour UTCMin UTCSec DeltaLS SyncLevel",
	        (double[]){utc.year % 100, utc.month, utc.day, utc.hour, utc.minute, utc.second, LEAP_S,
	                   s->n > 0 ? 7 : 3});
	end();
	begin("QualityInd", second * 1000);
	set("N", 3);
	for (int i = 0; i < 3; i++) {
		add(0);
		set("Indicators", quality[i][0] | (s->n > 0 ? quality[i][1] : 2) << 8);
	}
	end();
}

static void health(int second)
{
	begin("ReceiverStatus", second * 1000);
	set("CPULoad", 21 + (double)fw_random_below(&noise, 5));
	set("UpTime", 2417 + second);
	set("RxState", 1 << 1 | 1 << 3);
	set("N", 3);
	set("SBLength", 4);
	set("CmdCount", 12);
	set("Temperature", 100 + 41);
	for (unsigned i = 0; i < 3; i++) {
		add(0);
		set("FrontEndID", i);
		set("Gain", 36 + i);
		set("SampleVar", 98 + (double)fw_random_below(&noise, 5));
	}
	end();
}

/* ---- events and sensors, which come between the epochs ---- */

/* The shutter, some 30 ms after every other second. */
static void camera(int second)
{
	double after_s = 0.0318 + 0.004 * fw_random_uniform(&noise), fraction_s = fmod(after_s, 1e-3);
	begin("ExtEvent", second * 1000 + (int64_t)(after_s * 1000));
	set("Source", 1);
	set("Offset", fraction_s);
	set("RxClkBias", rounded(scene_clock_s(SCENE_START_S + second), 1e-12));
	set("PVTAge", 0);
	end();
}

static void sensor(unsigned type, const double value[static 3], double unit, double sd, double step)
{
	add(0);
	set("Source", 1);
	set("SensorModel", 4); /* simulated */
	set("Type", type);
	for (unsigned k = 0; k < 3; k++)
		set_at("Data", k, rounded(value[k] * unit + normal(sd), step));
}

static void inertial(int64_t ms)
{
	enum { ACCELERATION, ANGULAR_RATE };
	scene_drone d;
	scene_fly(SCENE_START_S + (double)ms / 1000, &d);
	begin("ExtSensorMeas", ms);
	set("N", 2);
	set("SBLength", 28);
	sensor(ACCELERATION, d.force_b, 1, 0.03, 1e-5);
	sensor(ANGULAR_RATE, d.turn_b, 180 / FW_PI, 0.05, 1e-5);
	end();
}

/* ---- navigation messages ---- */

#define NO_PERTURBATIONS "a_f2 a_f1 C_rs DEL_N C_uc C_us C_ic C_is C_rc OMEGADOT IDOT"

static void circular_orbit(const scene_satellite *s)
{
	set_all(NO_PERTURBATIONS, (double[11]){0});
	set_all("SQRT_A M_0 e i_0 omega OMEGA_0", (double[]){s->sqrt_a, s->m0, 0, s->i0, 0, s->omega0});
	set_all("t_oe t_oc a_f0", (double[]){SCENE_TOE_S, SCENE_TOE_S, s->clock_s});
}

static void gps_orbit(const scene_satellite *s, int64_t ms)
{
	begin("GPSNav", ms);
	set_all("PRN WN CAorPonL2 IODC IODE2 IODE3 T_gd",
	        (double[]){s->svid, SCENE_WEEK % 1024, 1, LNAV_IODE, LNAV_IODE, LNAV_IODE, 0});
	set_all("WNt_oc WNt_oe", (double[]){SCENE_WEEK % 1024, SCENE_WEEK % 1024});
	circular_orbit(s);
	end();
}

static void galileo_orbit(const scene_satellite *s, int64_t ms)
{
	begin("GALNav", ms);
	set_all("SVID Source IODnav Health_OSSOL", (double[]){s->svid, 2, 80, 1 | 1 << 4});
	set_all("SISA_L1E5b BGD_L1E5a BGD_L1E5b", (double[]){107, 0, 0});
	set_all("WNt_oc WNt_oe", (double[]){SCENE_WEEK % 4096, SCENE_WEEK % 4096});
	circular_orbit(s);
	end();
}

static void beidou_orbit(const scene_satellite *s, int64_t ms)
{
	int week = SCENE_WEEK - 1356;
	begin("BDSNav", ms);
	set_all("PRN WN URA SatH1 IODC IODE T_GD1 T_GD2", (double[]){s->svid, week, 2, 0, 1, 1, 0, 0});
	set_all("WNt_oc WNt_oe", (double[]){week, week});
	circular_orbit(s);
	end();
}

/* Where the satellite is at t_b, the next quarter of an hour of Moscow: 08:30:00 UTC. */
static void glonass_orbit(const scene_satellite *s, int64_t ms)
{
	enum { TB_MIN = 11 * 60 + 30, TOE_S = SCENE_START_S + 3 };
	double pos[3], vel[3];
	int n4, day;
	int64_t tod_ns;
	fw_time toe;
	scene_orbit(s, TOE_S, pos, vel);
	check(fw_time_from_gps(SCENE_WEEK, TOE_S * FW_NS_PER_S, &toe), "time");
	check(fw_time_to_glonass(toe, &n4, &day, &tod_ns), "time");
	begin("GLONav", ms);
	set_all("SVID FreqNr", (double[]){s->svid, s->channel + 8});
	for (int i = 0; i < 3; i++) {
		set((const char *[]){"X", "Y", "Z"}[i], rounded(pos[i] / 1000, 0x1p-11));
		set((const char *[]){"Dx", "Dy", "Dz"}[i], rounded(vel[i] / 1000, 0x1p-20));
		set((const char *[]){"Ddx", "Ddy", "Ddz"}[i], 0);
	}
	set_all("gamma tau dtau t_oe WN_toe", (double[]){0, -s->clock_s, 0, TOE_S, SCENE_WEEK % 1024});
	set_all("P1 P2 tb M P N_T F_T C", (double[]){30, 1, TB_MIN, 1, 3, day, 250, 1});
	end();
}

/* When the messages of a system are complete. */
static void orbits(int second)
{
	for (int i = 0; i < SCENE_SATELLITES; i++) {
		const scene_satellite *s = &sky[i];
		if (second != s->usable_s)
			continue;
		switch (s->name[0]) {
		case 'G': gps_orbit(s, second * 1000); break;
		case 'E': galileo_orbit(s, second * 1000); break;
		case 'C': beidou_orbit(s, second * 1000); break;
		default: glonass_orbit(s, second * 1000);
		}
	}
}

/* The page with ionosphere and UTC ends with a subframe 4, nine seconds into the log. */
static void gps_almanac_page(int second)
{
	begin("GPSIon", second * 1000);
	set("PRN", sky[0].svid);
	set_all("alpha_0 alpha_1 alpha_2 alpha_3",
	        (double[]){12 * 0x1p-30, 2 * 0x1p-27, -1 * 0x1p-24, -1 * 0x1p-24});
	set_all("beta_0 beta_1 beta_2 beta_3", (double[]){46 * 0x1p11, 3 * 0x1p14, -2 * 0x1p16, -4 * 0x1p16});
	end();
	begin("GPSUtc", second * 1000);
	set("PRN", sky[0].svid);
	set_all("A_1 A_0 t_ot WN_t DEL_t_LS WN_LSF DN DEL_t_LSF",
	        (double[]){0, -3 * 0x1p-30, 405504, SCENE_WEEK % 256, LEAP_S, 137, 7, LEAP_S});
	end();
}

/* Subframes 1 to 3 as the satellites send them, six seconds each, 30 a frame. */
static void raw_pages(int second)
{
	unsigned end_s = (unsigned)(SCENE_START_S + second), id = (end_s / 6 + 4) % 5 + 1;
	if (end_s % 6 != 0 || id > 3)
		return;
	for (unsigned i = 0; i < SCENE_SATELLITES && sky[i].name[0] == 'G'; i++) {
		uint32_t words[LNAV_WORDS];
		lnav_subframe(&sky[i], id, end_s, words);
		begin("GPSRawCA", second * 1000);
		set_all("SVID CRCPassed RxChannel", (double[]){sky[i].svid, 1, i + 1});
		for (unsigned k = 0; k < LNAV_WORDS; k++)
			set_at("NAVBits", k, words[k]);
		end();
	}
}

/* ---- SBAS ---- */

enum { GPS_IN_MASK = 30, MASKED = GPS_IN_MASK + 2, PLACES = 51, GRID_POINTS = 45 };

static int udrei(int mask_no)
{
	return mask_no > GPS_IN_MASK ? 14 : 4 + mask_no % 3;
}

static void put_mask(uint8_t *message)
{
	char name[16];
	for (int i = 1; i <= MASKED; i++) {
		if (i <= GPS_IN_MASK)
			snprintf(name, sizeof name, "G%02d", i);
		else
			snprintf(name, sizeof name, "%s", i == MASKED ? "S136" : GEO);
		furrow_sbas_mask r = {.iodp = 1, .mask_no = (int16_t)i, .mask_sat = name};
		check(fw_sbas_add(FW_sbas_mask, &r, message), "SBAS mask");
	}
}

static void put_fast(uint8_t *message, int type, int second)
{
	for (int i = 1; i <= 13; i++) {
		int no = 13 * (type - 2) + i;
		furrow_sbas_fast r = {.type = (int16_t)type,
		                      .iodp = 1,
		                      .iodf = (int16_t)(second / 6 % 3),
		                      .mask_no = (int16_t)no};
		r.udrei = (int16_t)udrei(no);
		r.prc_m = no > MASKED ? 0 : 2.5 * sin(no) + normal(0.1);
		check(fw_sbas_add(FW_sbas_fast, &r, message), "SBAS fast corrections");
	}
}

static void put_integrity(uint8_t *message)
{
	for (int i = 1; i <= PLACES; i++) {
		furrow_sbas_integrity r = {
		    .iodf2 = 3, .iodf3 = 3, .iodf4 = 3, .iodf5 = 3, .mask_no = (int16_t)i};
		r.udrei = (int16_t)udrei(i);
		check(fw_sbas_add(FW_sbas_integrity, &r, message), "SBAS integrity");
	}
}

static void put_degradation(uint8_t *message)
{
	for (int i = 1; i <= PLACES; i++) {
		furrow_sbas_degradation r = {.iodp = 1, .latency_s = 4, .mask_no = (int16_t)i, .ai = 8};
		check(fw_sbas_add(FW_sbas_degradation, &r, message), "SBAS degradation");
	}
}

static void put_orbit(uint8_t *message, double t)
{
	double pos[3], vel[3];
	const scene_satellite *geo = &sky[SCENE_SATELLITES - 1];
	scene_orbit(geo, t, pos, vel);
	furrow_eph_sbas r = {.iodn = 17, .t0_s = (int32_t)fmod(t, 86400) / 16 * 16, .ura = 4};
	r.x_m = pos[0];
	r.y_m = pos[1];
	r.z_m = pos[2];
	check(fw_sbas_add(FW_eph_sbas, &r, message), "SBAS orbit");
}

static void put_factors(uint8_t *message)
{
	furrow_sbas_factors r = {.cltc_lsb_m = 0.152,
	                         .cltc_v1_mps = 0.00085,
	                         .iltc_v1_s = 120,
	                         .cltc_v0_m = 0.152,
	                         .iltc_v0_s = 120,
	                         .cgeo_lsb_m = 0.5,
	                         .cgeo_v_mps = 0.00005,
	                         .igeo_s = 120,
	                         .cer_m = 31.5F,
	                         .ciono_step_m = 0.43,
	                         .iiono_s = 300};
	check(fw_sbas_add(FW_sbas_factors, &r, message), "SBAS factors");
}

static void put_time(uint8_t *message, double t)
{
	furrow_sbas_time r = {.a0_s = 5 * 0x1p-30,
	                      .tot_s = 405504,
	                      .wnt = SCENE_WEEK % 256,
	                      .leap_s = LEAP_S,
	                      .wnlsf = 137,
	                      .dn = 7,
	                      .leap_future_s = LEAP_S,
	                      .utc_std = 3,
	                      .gps_wn = SCENE_WEEK % 1024};
	r.gps_tow_s = (int32_t)t;
	check(fw_sbas_add(FW_sbas_time, &r, message), "SBAS time");
}

static void put_almanac(uint8_t *message, double t)
{
	const double longitude_deg[] = {31.5, 5};
	for (int i = 0; i < 2; i++) {
		double longitude = fw_rad_from_deg(longitude_deg[i]);
		furrow_sbas_almanac r = {.sat = (char *)(uintptr_t)(i == 0 ? GEO : "S136"), .health = 16};
		r.toa_s = SCENE_WEEK * INT64_C(604800) + (int64_t)t / 64 * 64;
		r.x_m = 42164e3 * cos(longitude);
		r.y_m = 42164e3 * sin(longitude);
		check(fw_sbas_add(FW_sbas_almanac, &r, message), "SBAS almanac");
	}
}

static void put_grid_mask(uint8_t *message)
{
	for (int i = 0; i < GRID_POINTS; i++) {
		furrow_sbas_igp_mask r = {.bands = 5, .band = 5, .iodi = 2, .mask_no = (int16_t)(i + 1)};
		r.igp = (int16_t)(10 + 4 * i);
		check(fw_sbas_add(FW_sbas_igp_mask, &r, message), "SBAS grid mask");
	}
}

static void put_iono(uint8_t *message, int second)
{
	int first = second / 12 % 3 * 15;
	for (int i = 1; i <= 15; i++) {
		furrow_sbas_iono r = {
		    .band = 5, .iodi = 2, .mask_no = (int16_t)(first + i), .givei = (int16_t)(7 + i % 4)};
		r.delay_m = 1.5 + 0.125 * i;
		check(fw_sbas_add(FW_sbas_iono, &r, message), "SBAS ionosphere");
	}
}

static void put_long(uint8_t *message, int second)
{
	for (int half = 0; half < 2; half++) {
		furrow_sbas_long r = {.velocity_code = 1, .iodp = 1, .iode = LNAV_IODE};
		r.mask_no = (int16_t)(1 + (second / 4 + half) % GPS_IN_MASK);
		r.dx_m = 0.375F;
		r.dy_m = -0.75F;
		r.dz_m = 0.125F * (float)(half + 1);
		r.daf0_s = -3 * 0x1p-31F;
		r.toe_s = (int32_t)fmod(SCENE_START_S, 86400) / 16 * 16;
		check(fw_sbas_add(FW_sbas_long, &r, message), "SBAS long-term corrections");
	}
}

static void put_service(uint8_t *message)
{
	furrow_sbas_service r = {.iods = 1,
	                         .messages = 1,
	                         .message_no = 1,
	                         .priority = 1,
	                         .dudre_in = 0,
	                         .dudre_out = 11,
	                         .lat1_deg = 20,
	                         .lon1_deg = -40,
	                         .lat2_deg = 72,
	                         .lon2_deg = 40,
	                         .shape = 1};
	check(fw_sbas_add(FW_sbas_service, &r, message), "SBAS service");
}

/* The message that ends with this second. Type 63 is the one that says nothing. */
static void sbas(int second)
{
	static const uint8_t schedule[] = {63, 1, 2,  3,  4, 26, 25, 9, 2,  3,  4,  18, 7, 26, 2,
	                                   3,  4, 25, 10, 6, 2,  3,  4, 26, 17, 12, 2,  3, 4,  27};
	int type = schedule[(size_t)second % sizeof schedule];
	double t = SCENE_START_S + second - 1;
	uint8_t message[FW_SBAS_BYTES];
	check(fw_sbas_begin((unsigned)type, (unsigned)t, message), "SBAS message");
	switch (type) {
	case 1: put_mask(message); break;
	case 2:
	case 3:
	case 4: put_fast(message, type, second); break;
	case 6: put_integrity(message); break;
	case 7: put_degradation(message); break;
	case 9: put_orbit(message, t); break;
	case 10: put_factors(message); break;
	case 12: put_time(message, t); break;
	case 17: put_almanac(message, t); break;
	case 18: put_grid_mask(message); break;
	case 25: put_long(message, second); break;
	case 26: put_iono(message, second); break;
	case 27: put_service(message); break;
	default: break;
	}
	fw_sbas_finish(message);
	begin("GEORawL1", second * 1000);
	set_all("SVID CRCPassed ViterbiCnt Source RxChannel",
	        (double[]){fw_sbf_svid(GEO), 1, 0, 24, SCENE_SATELLITES});
	for (unsigned k = 0; k < FW_SBAS_BYTES / 4; k++) {
		uint8_t *p = message + 4 * k;
		set_at("NAVBits", k,
		       (double)((uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3]));
	}
	end();
}

/* ---- the log ---- */

static void epoch(int second)
{
	int64_t ms = second * 1000;
	double t =
	    SCENE_START_S + second - scene_clock_s(SCENE_START_S + second); /* what GPS time really is */
	scene_drone drone;
	scene_view views[SCENE_SATELLITES];
	scene_fly(t, &drone);
	for (int i = 0; i < SCENE_SATELLITES; i++)
		scene_look(&sky[i], &drone, t, &views[i]);
	solution s = solve(second, views);

	measurements(second, t, views);
	if (second % 10 == 0)
		more_measurements(second, views);
	marker("EndOfMeas", ms);
	position(second, &drone, &s);
	covariance("PosCovGeodetic", second, &s, RANGE_SD_M * RANGE_SD_M,
	           "Cov_latlat Cov_lonlon Cov_hgthgt Cov_bb Cov_latlon Cov_lathgt Cov_latb Cov_lonhgt "
	           "Cov_lonb Cov_hb");
	covariance(
	    "VelCovGeodetic", second, &s, 4e-4,
	    "Cov_VnVn Cov_VeVe Cov_VuVu Cov_DtDt Cov_VnVe Cov_VnVu Cov_VnDt Cov_VeVu Cov_VeDt Cov_VuDt");
	dilution(second, &s);
	marker("EndOfPVT", ms);
	attitude(second, &drone, &s);
	if (s.n > 0)
		inertial_solution(second, &drone, &s);
	clock_and_quality(second, &s);
	if (second % 5 == 0)
		health(second);
}

static int in_sensor_window(int64_t ms)
{
	return ms >= 10000 && ms < 20000;
}

int main(void)
{
	fw_random_init(&noise, 20260610);
	scene_sky(sky);
	setup();
	for (int64_t ms = 0; ms < SCENE_SECONDS * 1000; ms += 100) {
		int second = (int)(ms / 1000);
		if (ms % 1000 == 0) {
			raw_pages(second);
			orbits(second);
			if (second == 9)
				gps_almanac_page(second);
			sbas(second);
			epoch(second);
		}
		if (in_sensor_window(ms))
			inertial(ms);
		if (ms % 2000 == 0 && second >= 4)
			camera(second);
	}
	if (fclose(stdout) != 0)
		check(FW_EIO, "output");
	return 0;
}
