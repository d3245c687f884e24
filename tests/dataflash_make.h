/* ArduPilot's binary logs in the making: the messages of ArduPilot 4.5 with those columns that furrow reads
 * and some that it does not. */
#ifndef FURROW_TESTS_DATAFLASH_MAKE_H
#define FURROW_TESTS_DATAFLASH_MAKE_H

#include "log_bytes.h"

enum { DF_IMU = 150, DF_MAG, DF_BARO, DF_GPS, DF_GPA, DF_ATT, DF_CAM, DF_PARM, DF_ACC, DF_GYR, DF_TEXT };

static inline void df_begin(log_bytes *b, int id)
{
	put_le(b, 0x95a3, 2);
	put_le(b, (uint64_t)id, 1);
}

static inline void df_format(log_bytes *b, int id, int length, const char *name, const char *format,
                             const char *labels)
{
	df_begin(b, 128);
	put_le(b, (uint64_t)id, 1);
	put_le(b, (uint64_t)length, 1);
	put_text(b, name, 4);
	put_text(b, format, 16);
	put_text(b, labels, 64);
}

static inline void df_formats(log_bytes *b)
{
	df_format(b, 128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
	df_format(b, DF_PARM, 35, "PARM", "QNff", "TimeUS,Name,Value,Default");
	df_format(b, DF_IMU, 54, "IMU", "QBffffffIIfBBHH",
	          "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz");
	df_format(b, DF_MAG, 35, "MAG", "QBhhhhhhhhhBI",
	          "TimeUS,I,MagX,MagY,MagZ,OfsX,OfsY,OfsZ,MOX,MOY,MOZ,Health,S");
	df_format(b, DF_BARO, 39, "BARO", "QBffcfIffB",
	          "TimeUS,I,Alt,Press,Temp,CRt,SMS,Offset,GndTemp,Health");
	df_format(b, DF_GPS, 51, "GPS", "QBBIHBcLLeffffB",
	          "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U");
	df_format(b, DF_GPA, 39, "GPA", "QBCCCCfBIHeHH",
	          "TimeUS,I,VDop,HAcc,VAcc,SAcc,YAcc,VV,SMS,Delta,AEl,RTCMFU,RTCMFD");
	df_format(b, DF_ATT, 28, "ATT", "QccccCCCCB",
	          "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw,ErrRP,ErrYaw,AEKF");
	df_format(b, DF_CAM, 46, "CAM", "QBHIHLLeeeccC",
	          "TimeUS,I,Img,GPSTime,GPSWeek,Lat,Lng,Alt,RelAlt,GPSAlt,R,P,Y");
	df_format(b, DF_ACC, 32, "ACC", "QBQfff", "TimeUS,I,SampleUS,AccX,AccY,AccZ");
	df_format(b, DF_GYR, 32, "GYR", "QBQfff", "TimeUS,I,SampleUS,GyrX,GyrY,GyrZ");
	df_format(b, DF_TEXT, 75, "MSG", "QZ", "TimeUS,Message");
}

static inline void df_parameter(log_bytes *b, const char *name, float value)
{
	df_begin(b, DF_PARM);
	put_le(b, 1000, 8);
	put_text(b, name, 16);
	put_f32(b, value);
	put_f32(b, 0);
}

static inline void df_imu(log_bytes *b, uint64_t us, int instance, float gx, float az, int healthy)
{
	const float v[6] = {gx, 0.25F, -0.5F, 1, 2, az};

	df_begin(b, DF_IMU);
	put_le(b, us, 8);
	put_le(b, (uint64_t)instance, 1);
	for (int i = 0; i < 6; i++)
		put_f32(b, v[i]);
	put_le(b, 0, 8);
	put_f32(b, 30);
	put_le(b, (uint64_t)healthy, 1);
	put_le(b, 1, 1);
	put_le(b, 0, 4);
}

/* ACC or GYR */
static inline void df_raw(log_bytes *b, int id, uint64_t us, float x)
{
	df_begin(b, id);
	put_le(b, us + 300, 8);
	put_le(b, 0, 1);
	put_le(b, us, 8);
	put_f32(b, x);
	put_f32(b, 2);
	put_f32(b, 3);
}

static inline void df_mag(log_bytes *b, uint64_t us, int instance, int x, int healthy)
{
	df_begin(b, DF_MAG);
	put_le(b, us, 8);
	put_le(b, (uint64_t)instance, 1);
	put_le(b, (uint16_t)x, 2);
	put_le(b, (uint16_t)-100, 2);
	put_le(b, 400, 2);
	for (int i = 0; i < 6; i++)
		put_le(b, 7, 2);
	put_le(b, (uint64_t)healthy, 1);
	put_le(b, 0, 4);
}

static inline void df_baro(log_bytes *b, uint64_t us, float height)
{
	df_begin(b, DF_BARO);
	put_le(b, us, 8);
	put_le(b, 0, 1);
	put_f32(b, height);
	put_f32(b, 95000);
	put_le(b, 2500, 2);
	put_f32(b, 0);
	put_le(b, us / 1000, 4);
	put_f32(b, 0);
	put_f32(b, 20);
	put_le(b, 1, 1);
}

typedef struct {
	uint64_t us;
	int instance, status, used;
	uint32_t week_ms;
	uint16_t week;
} df_fix;

/* 48.5 N, 7.25 W, 200.5 m above the sea, 10 m/s towards 90 deg, 1.5 m/s down. */
static inline void df_gps(log_bytes *b, const df_fix *f)
{
	df_begin(b, DF_GPS);
	put_le(b, f->us, 8);
	put_le(b, (uint64_t)f->instance, 1);
	put_le(b, (uint64_t)f->status, 1);
	put_le(b, f->week_ms, 4);
	put_le(b, f->week, 2);
	put_le(b, 17, 1);
	put_le(b, 75, 2);
	put_le(b, 485000000, 4);
	put_le(b, (uint32_t)-72500000, 4);
	put_le(b, 20050, 4);
	put_f32(b, 10);
	put_f32(b, 90);
	put_f32(b, 1.5F);
	put_f32(b, 0);
	put_le(b, (uint64_t)f->used, 1);
}

/* 2 m horizontally, 3 m vertically, 0.5 m/s; ellipsoidal height in cm. */
static inline void df_accuracy(log_bytes *b, const df_fix *f, int32_t ellipsoid_cm)
{
	df_begin(b, DF_GPA);
	put_le(b, f->us, 8);
	put_le(b, (uint64_t)f->instance, 1);
	put_le(b, 100, 2);
	put_le(b, 200, 2);
	put_le(b, 300, 2);
	put_le(b, 50, 2);
	put_f32(b, 0);
	put_le(b, 1, 1);
	put_le(b, f->us / 1000, 4);
	put_le(b, 200, 2);
	put_le(b, (uint32_t)ellipsoid_cm, 4);
	put_le(b, 0, 4);
}

/* roll 1.5, pitch -2.25, yaw 271 deg */
static inline void df_attitude(log_bytes *b, uint64_t us)
{
	df_begin(b, DF_ATT);
	put_le(b, us, 8);
	put_le(b, 0, 2);
	put_le(b, 150, 2);
	put_le(b, 0, 2);
	put_le(b, (uint16_t)-225, 2);
	put_le(b, 0, 2);
	put_le(b, 27100, 2);
	put_le(b, 0, 4);
	put_le(b, 3, 1);
}

static inline void df_camera(log_bytes *b, uint64_t us)
{
	df_begin(b, DF_CAM);
	put_le(b, us, 8);
	for (int i = 0; i < 35; i++)
		put_le(b, 1, 1);
}

static inline void df_message(log_bytes *b, uint64_t us, const char *text)
{
	df_begin(b, DF_TEXT);
	put_le(b, us, 8);
	put_text(b, text, 64);
}

#endif
