/* The Stanford diagram: what became of the user at an epoch, from the true error, the protection level (the bound that
 * the user knew) and the alert limit (the error that the operation bears). */
#ifndef FURROW_INTEGRITY_STANFORD_H
#define FURROW_INTEGRITY_STANFORD_H

typedef enum {
	FW_NOMINAL,    /* error <= PL <= AL */
	FW_MISLEADING, /* MI: PL < error <= AL: the bound did not hold, no harm was done */
	FW_HAZARDOUS, /* HMI: PL <= AL < error: nothing warned of an error that the operation does not bear */
	FW_UNAVAILABLE,            /* error <= PL, PL > AL: the user was told not to use the position */
	FW_UNAVAILABLE_MISLEADING, /* AL < PL < error: likewise, though the bound did not hold */
	FW_STANFORD_CLASSES
} fw_stanford;

/* The class of an epoch.
 *   error  in  magnitude of the position error [m]
 *   pl     in  protection level [m]
 *   al     in  alert limit [m]; infinite when there is none: every epoch is then nominal or misleading
 * An error that is NaN counts as not bounded; a level that is NaN as above the limit.
 * Source: M. Tossaint et al., "The Stanford-ESA Integrity Diagram: A New Tool for the User Domain SBAS Integrity
 * Assessment", Navigation 54 no. 2 (2007), pp. 153-162: the Stanford plot that it starts from. */
fw_stanford fw_stanford_class(double error, double pl, double al);

#endif
