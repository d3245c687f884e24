#include "sim/fault.h"

#include <stddef.h>

#include "base/frame.h"

bool fw_mask_covers(const fw_mask *mask, fw_satellite s, double azimuth_rad, double elevation_rad)
{
	double width = fw_wrap_2pi(mask->azimuth_to_rad - mask->azimuth_from_rad);
	bool in_sector = !(width > 0) || fw_wrap_2pi(azimuth_rad - mask->azimuth_from_rad) <= width;
	return in_sector && elevation_rad <= mask->below_rad && fw_satellite_in(&mask->satellites, s);
}

double fw_masks_attenuation_db(const fw_mask *masks, unsigned n, const fw_satellite_set *kept,
                               unsigned station, double t_s, fw_satellite s, double azimuth_rad,
                               double elevation_rad)
{
	double db = 0;
	for (unsigned i = 0; i < n; i++) {
		const fw_mask *mask = &masks[i];
		bool on = (mask->stations & station) != 0 && fw_window_holds(mask->window, t_s);
		if (!on || (mask->keep > 0 && kept != NULL && fw_satellite_in(&kept[i], s)))
			continue;
		if (fw_mask_covers(mask, s, azimuth_rad, elevation_rad))
			db += mask->attenuation_db;
	}
	return db;
}

bool fw_faults_hold(const fw_fault *faults, unsigned n, fw_fault_kind kind, unsigned station, double t_s)
{
	for (unsigned i = 0; i < n; i++)
		if (faults[i].kind == kind && (faults[i].stations & station) != 0 &&
		    fw_window_holds(faults[i].window, t_s))
			return true;
	return false;
}
