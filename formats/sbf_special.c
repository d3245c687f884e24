#include "formats/sbf_special.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "formats/bytes.h"
#include "furrow_event_columns.h"
#include "furrow_ext_sensor_columns.h"
#include "furrow_imu_columns.h"
#include "furrow_imu_setup_columns.h"
#include "furrow_residual_columns.h"
#include "furrow_satpos_columns.h"

#define BIT(type, column)           (INT64_C(1) << FW_COL_##type##_##column)
#define HAS(r, type, column)        (((r)->present & BIT(type, column)) != 0)
#define SET(r, type, column, value) ((r)->column = (value), (void)((r)->present |= BIT(type, column)))
#define CLEAR(r, type, column)      ((r)->column = 0, (void)((r)->present &= ~BIT(type, column)))

#define SECONDS_PER_WEEK 604800.0
#define DEG_TO_RAD       (M_PI / 180)

/* Do-not-use is -2e10. */
#define LOWEST (-1.9e10)

void fw_sbf_place_event(furrow_event *event)
{
	if (!HAS(event, event, tow_s))
		return;
	SET(event, event, rx_tow_s, event->tow_s);
	double correction = event->offset_s - event->clock_bias_s; /* absent ones are 0 */
	if (!(fabs(correction) < SECONDS_PER_WEEK)) {
		CLEAR(event, event, gps_week);
		CLEAR(event, event, tow_s);
		return;
	}
	double tow = event->tow_s + correction;
	int weeks = 0;
	if (tow < 0) {
		tow += SECONDS_PER_WEEK;
		weeks--;
	}
	if (tow >= SECONDS_PER_WEEK) { /* also when a hair below 0 was rounded up to the week's end */
		tow -= SECONDS_PER_WEEK;
		weeks++;
	}
	event->tow_s = tow;
	if (HAS(event, event, gps_week))
		event->gps_week += weeks;
}

void fw_sbf_set_delays(furrow_satpos *satpos, const uint8_t *sub, size_t size)
{
	CLEAR(satpos, satpos, iono_m);
	CLEAR(satpos, satpos, tropo_m);
	if (size < 46) /* revision 0 has none */
		return;
	int16_t iono = (int16_t)fw_load_u16(sub + 40), tropo = (int16_t)fw_load_u16(sub + 42);
	if (iono != INT16_MIN)
		SET(satpos, satpos, iono_m, (iono * 256 + sub[44]) / 2560.0);
	if (tropo != INT16_MIN)
		SET(satpos, satpos, tropo_m, (tropo * 256 + sub[45]) / 2560.0);
}

void fw_sbf_set_quantity(furrow_residual *residual, uint8_t meas_info, unsigned k, const uint8_t *info,
                         size_t size)
{
	static const struct {
		const char *name;
		double mdb_divisor; /* 0.1 m, 0.01 cycle, 0.01 m/s */
	} quantities[] = {{"code", 10}, {"carrier", 100}, {"doppler", 100}};

	unsigned quantity = 0;
	while (quantity < 2 && (!(meas_info >> quantity & 1) || k-- > 0))
		quantity++;
	const char *name = quantities[quantity].name;
	memcpy(&residual->quantity, &name, sizeof name); /* a char * that nobody writes through */
	residual->present |= BIT(residual, quantity);
	CLEAR(residual, residual, mdb);
	if (size >= 8 && fw_load_u16(info + 6) != UINT16_MAX)
		SET(residual, residual, mdb, fw_load_u16(info + 6) / quantities[quantity].mdb_divisor);
}

/* Types of external sensor measurements. */
enum { ACCELERATION = 0, ANGULAR_RATE = 1, INFORMATION = 3, VELOCITY = 4, ZERO_VELOCITY = 20 };

static void set_f64(furrow_ext_sensor *sensor, int column, double *member, double x)
{
	if (!(x >= LOWEST && x <= DBL_MAX))
		return;
	*member = x;
	sensor->present |= INT64_C(1) << column;
}

static void set_f32(furrow_ext_sensor *sensor, int column, float *member, float x)
{
	if (!(x >= (float)LOWEST && x <= FLT_MAX))
		return;
	*member = x;
	sensor->present |= INT64_C(1) << column;
}

#define F64(column, x) set_f64(s, FW_COL_ext_sensor_##column, &s->column, x)
#define F32(column, x) set_f32(s, FW_COL_ext_sensor_##column, &s->column, x)

void fw_sbf_set_sensor(furrow_ext_sensor *s, const uint8_t *data)
{
	switch (s->type) {
	case ACCELERATION:
		F64(accel_x_mps2, fw_load_f64(data));
		F64(accel_y_mps2, fw_load_f64(data + 8));
		F64(accel_z_mps2, fw_load_f64(data + 16));
		break;
	case ANGULAR_RATE: /* deg/s; the do-not-use value is told before the scaling */
		F64(gyro_x_radps, fw_load_f64(data));
		F64(gyro_y_radps, fw_load_f64(data + 8));
		F64(gyro_z_radps, fw_load_f64(data + 16));
		s->gyro_x_radps *= DEG_TO_RAD;
		s->gyro_y_radps *= DEG_TO_RAD;
		s->gyro_z_radps *= DEG_TO_RAD;
		break;
	case INFORMATION:
		if ((int16_t)fw_load_u16(data) != INT16_MIN)
			F64(temperature_degc, (int16_t)fw_load_u16(data) / 100.0);
		break;
	case VELOCITY:
		F32(vx_mps, fw_load_f32(data));
		F32(vy_mps, fw_load_f32(data + 4));
		F32(vz_mps, fw_load_f32(data + 8));
		F32(sd_vx_mps, fw_load_f32(data + 12));
		F32(sd_vy_mps, fw_load_f32(data + 16));
		F32(sd_vz_mps, fw_load_f32(data + 20));
		break;
	case ZERO_VELOCITY: F64(zero_velocity, fw_load_f64(data)); break;
	default: break;
	}
}

bool fw_sbf_mounting(const furrow_imu_setup *setup, double C[9])
{
	if (!HAS(setup, imu_setup, theta_x_deg) || !HAS(setup, imu_setup, theta_y_deg) ||
	    !HAS(setup, imu_setup, theta_z_deg))
		return false;
	const double x = (double)setup->theta_x_deg * DEG_TO_RAD;
	const double y = (double)setup->theta_y_deg * DEG_TO_RAD;
	const double z = (double)setup->theta_z_deg * DEG_TO_RAD;
	const double sx = sin(x), cx = cos(x), sy = sin(y), cy = cos(y), sz = sin(z), cz = cos(z);
	const double product[9] = {
	    cz * cy,
	    cz * sy * sx - sz * cx,
	    cz * sy * cx + sz * sx, /* forward */
	    sz * cy,
	    sz * sy * sx + cz * cx,
	    sz * sy * cx - cz * sx, /* right */
	    -sy,
	    cy * sx,
	    cy * cx, /* down */
	};
	memcpy(C, product, sizeof product);
	return true;
}

/* y = C x, or x when there is no C. */
static void rotate(const double *C, const double x[3], double y[3])
{
	for (int i = 0; i < 3; i++)
		y[i] = C ? C[3 * i] * x[0] + C[3 * i + 1] * x[1] + C[3 * i + 2] * x[2] : x[i];
}

void fw_sbf_add_imu(furrow_imu *imu, const furrow_ext_sensor *sensor, const double *C)
{
	const int64_t accel =
	    BIT(ext_sensor, accel_x_mps2) | BIT(ext_sensor, accel_y_mps2) | BIT(ext_sensor, accel_z_mps2);
	const int64_t gyro =
	    BIT(ext_sensor, gyro_x_radps) | BIT(ext_sensor, gyro_y_radps) | BIT(ext_sensor, gyro_z_radps);
	double v[3];
	if ((sensor->present & accel) == accel && !HAS(imu, imu, accel_x_mps2)) {
		rotate(C, (const double[]){sensor->accel_x_mps2, sensor->accel_y_mps2, sensor->accel_z_mps2},
		       v);
		SET(imu, imu, accel_x_mps2, v[0]);
		SET(imu, imu, accel_y_mps2, v[1]);
		SET(imu, imu, accel_z_mps2, v[2]);
	}
	if ((sensor->present & gyro) == gyro && !HAS(imu, imu, gyro_x_radps)) {
		rotate(C, (const double[]){sensor->gyro_x_radps, sensor->gyro_y_radps, sensor->gyro_z_radps},
		       v);
		SET(imu, imu, gyro_x_radps, v[0]);
		SET(imu, imu, gyro_y_radps, v[1]);
		SET(imu, imu, gyro_z_radps, v[2]);
	}
}
