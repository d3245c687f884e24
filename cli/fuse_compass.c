#include "fuse_compass.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/frame.h"
#include "formats/number.h"
#include "ins/magnetic_field.h"

enum { NUMBERS = 12 };

/* A first run whose heading is less sure than this says nothing about a compass. */
#define HEADING_SD_MOST (5 * FW_PI / 180)

/* Faster than anyone turns a vehicle about to calibrate its compass [m/s]. */
#define GONE_MPS 2

static bool parse_numbers(const char *text, double numbers[static NUMBERS])
{
	const char *p = text;
	for (int i = 0; i < NUMBERS; i++) {
		const size_t n = strcspn(p, ",");
		if (fw_get_double(p, n, &numbers[i]) != FW_OK || !(fabs(numbers[i]) < 1e6))
			return false;
		p += n;
		if (*p != (i < NUMBERS - 1 ? ',' : '\0'))
			return false;
		p += *p == ',';
	}
	return true;
}

bool fuse_compass_parse(const char *text, fuse_compass_way *way, fw_mag_calibration *cal)
{
	double numbers[NUMBERS];
	if (strcmp(text, "none") == 0) {
		*way = FUSE_COMPASS_AS_IT_IS;
	} else if (strcmp(text, "turning") == 0) {
		*way = FUSE_COMPASS_TURNING;
	} else if (strcmp(text, "log") == 0) {
		*way = FUSE_COMPASS_LOG;
	} else if (parse_numbers(text, numbers)) {
		*way = FUSE_COMPASS_GIVEN;
		*cal = fw_mag_as_it_is(50, 0.5);
		memcpy(cal->offset, numbers, sizeof cal->offset);
		memcpy(cal->matrix, numbers + 3, sizeof cal->matrix);
	} else {
		return false;
	}
	return true;
}

void fuse_compass_print(const fw_mag_calibration *cal, char *text, size_t room)
{
	size_t used = 0;
	for (int i = 0; i < NUMBERS && used < room; i++)
		used +=
		    (size_t)snprintf(text + used, room - used, i < 3 ? "%s%.3f" : "%s%.5f", i > 0 ? "," : "",
		                     i < 3 ? cal->offset[i] : cal->matrix[(i - 3) / 3][i % 3]);
}

void fuse_compass_begin(fuse_compass *c, double declination_rad)
{
	*c = (fuse_compass){.declination_rad = declination_rad};
	fw_mag_turning_init(&c->turning);
	fw_mag_referenced_init(&c->referenced);
}

void fuse_compass_item(fuse_compass *c, const fw_item *item)
{
	if (item->kind == FW_ITEM_FIX && item->fix.has_velocity)
		c->gone |= hypot(item->fix.velocity_mps[0], item->fix.velocity_mps[1]) > GONE_MPS;
	if (item->kind != FW_ITEM_FIELD)
		return;
	if (!c->gone)
		(void)!fw_mag_turning_add(&c->turning, item->field.b_ut);
	c->reading = *item;
	c->waiting = true;
}

static bool know_field(fuse_compass *c, const fw_pva *pva)
{
	double *b = c->field_ned_nt;
	if (!c->has_field && fw_magnetic_field(pva->llh, pva->time, b) >= 0) {
		c->has_field = true;
		if (isfinite(c->declination_rad)) {
			const double h = hypot(b[0], b[1]);
			b[0] = h * cos(c->declination_rad);
			b[1] = h * sin(c->declination_rad);
		}
	}
	return c->has_field;
}

void fuse_compass_attitude(fuse_compass *c, const fw_loose *l)
{
	double sd[3];
	if (!c->waiting || l->filter.pva.time.ns < c->reading.time.ns || !know_field(c, &l->filter.pva))
		return;
	c->waiting = false;
	fw_attitude_sd(&l->filter, sd);
	if (sd[2] <= HEADING_SD_MOST)
		(void)!fw_mag_referenced_add(&c->referenced, l->filter.pva.q_n_b, c->field_ned_nt,
		                             c->reading.field.b_ut);
}

fw_status fuse_compass_solve(const fuse_compass *c, fuse_compass_way way, fw_mag_calibration *cal)
{
	if (!c->has_field)
		return FW_MORE;
	return way == FUSE_COMPASS_TURNING ? fw_mag_turning_solve(&c->turning, c->field_ned_nt, cal)
	                                   : fw_mag_referenced_solve(&c->referenced, cal);
}
