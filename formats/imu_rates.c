#include "formats/imu_rates.h"

#define GAP_FACTOR 1.5 /* an interval longer than so many usual ones is a gap */

enum { ODD_MOST = 5 };

fw_status fw_imu_rates_interval(fw_imu_rates *r, fw_time t, double *dt_s)
{
	double dt;

	if (r->n == 0) {
		r->n = 1;
		r->last = t;
		return FW_MORE;
	}
	if (fw_time_compare(t, r->last) <= 0)
		return FW_ERANGE;
	dt = fw_time_diff_s(t, r->last);
	r->last = t;
	if (r->n == 1 || dt < r->usual_s / GAP_FACTOR || ++r->odd >= ODD_MOST) { /* so far it was a guess */
		r->n = 2;
		r->usual_s = dt;
	}
	if (dt > GAP_FACTOR * r->usual_s) {
		*dt_s = r->usual_s;
		return FW_OK;
	}
	r->odd = 0;
	r->usual_s += (dt - r->usual_s) / 16;
	*dt_s = dt;
	return FW_OK;
}
