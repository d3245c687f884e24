#include "formats/sbf_schema.h"

#include <math.h>
#include <stddef.h>

/** IS-GPS-200, 20.3.3.4.3.3: the value of pi that broadcast orbits are computed with */
#define GPS_PI 3.1415926535898

/* A table line reads like a line of the reference guide: type("Name", offset, what becomes of it). */
#define FIELD(name_, offset_, type_, ...)                                                                    \
	{                                                                                                    \
		.name = (name_), .offset = (offset_), .count = 1, .type = (type_), __VA_ARGS__               \
	}
#define U1(name, offset, ...) FIELD(name, offset, SBF_U1, __VA_ARGS__)
#define U2(name, offset, ...) FIELD(name, offset, SBF_U2, __VA_ARGS__)
#define U4(name, offset, ...) FIELD(name, offset, SBF_U4, __VA_ARGS__)
#define I1(name, offset, ...) FIELD(name, offset, SBF_I1, __VA_ARGS__)
#define I2(name, offset, ...) FIELD(name, offset, SBF_I2, __VA_ARGS__)
#define I4(name, offset, ...) FIELD(name, offset, SBF_I4, __VA_ARGS__)
#define F4(name, offset, ...) FIELD(name, offset, SBF_F4, __VA_ARGS__)
#define F8(name, offset, ...) FIELD(name, offset, SBF_F8, __VA_ARGS__)
#define C1(name, offset, ...) FIELD(name, offset, SBF_C1, __VA_ARGS__)

#define ARRAY(name_, offset_, type_, count_)                                                                 \
	{                                                                                                    \
		.name = (name_), .offset = (offset_), .count = (count_), .type = SBF_##type_                 \
	}
#define RESERVED(offset, count) ARRAY("reserved", offset, U1, count)
#define TEXT(name_, offset_, count_, column_)                                                                \
	{                                                                                                    \
		.name = (name_), .offset = (offset_), .count = (count_), .type = SBF_C1,                     \
		.convert = SBF_TEXT, .column = (column_)                                                     \
	}
#define HEX(name_, offset_, count_, column_)                                                                 \
	{                                                                                                    \
		.name = (name_), .offset = (offset_), .count = (count_), .type = SBF_U4, .convert = SBF_HEX, \
		.column = (column_)                                                                          \
	}

/* Views. */
#define BITS(name, offset, type, shift_, width_, ...)                                                        \
	FIELD(name, offset, SBF_##type, .shift = (shift_), .width = (width_), __VA_ARGS__)
#define ROOT(name, offset, type, ...) BITS(name, offset, type, 0, 32, AS(ROOT), __VA_ARGS__)
#define INDEX(column)                 BITS("number of the entry", 0, U1, 0, 8, AS(INDEX), TO(column))
#define CONSTANT(text, column)        BITS(text, 0, U1, 0, 8, AS(CONSTANT), TO(column))
#define DECODED                       CONSTANT("decoded", "source")

/* What becomes of a field. */
#define TO(column_)                     .column = (column_)
#define AS(convert_)                    .convert = SBF_##convert_
#define TIMES(factor)                   .mul = (factor)
#define PER(divisor)                    .div = (divisor)
#define PLUS(term)                      .add = (term)
#define SINCE(revision)                 .since = (revision)
#define DNU                             .dnu = SBF_DNU
#define DNU_ZERO                        .dnu = SBF_DNU_ZERO
#define RAD_TO_DEG                      TIMES(180 / M_PI)
#define SEMICIRCLES                     TIMES(GPS_PI)
#define KILO                            TIMES(1000)
#define NEGATED                         TIMES(-1)
#define SATELLITE(name, offset, column) U1(name, offset, TO(column), AS(SATELLITE))
#define GLO_CHANNEL(name, offset)       U1(name, offset, TO("glonass_channel"), PLUS(-8), DNU_ZERO, AS(CHANNEL))

/* Groups: where the first sub-block starts, what counts them, how long they are. */
#define COUNT_U1(start_, at) .start = (start_), .count = SBF_COUNT_U1, .count_offset = (at)
#define COUNT_U2(start_, at) .start = (start_), .count = SBF_COUNT_U2, .count_offset = (at)
#define COUNT_BIT(start_, at, bit)                                                                           \
	.start = (start_), .count = SBF_COUNT_BIT, .count_offset = (at), .count_bit = (bit)
#define COUNT_BITS(at, bits)       .count = SBF_COUNT_BITS, .count_offset = (at), .count_bit = (bits)
#define COUNT_FIXED(start_, times) .start = (start_), .count = SBF_COUNT_FIXED, .count_bit = (times)
#define SIZE(size_)                .size = (size_)
#define SIZE_AT(at, size_)         .size_offset = (at), .size = (size_)
#define FIELDS(list)               .n_fields = sizeof(list) / sizeof((list)[0]), .fields = (list)
#define GROUPS(list)               .n_groups = sizeof(list) / sizeof((list)[0]), .groups = (list)

#include "formats/sbf_schema_position.inc"
#include "formats/sbf_schema_navigation.inc"
#include "formats/sbf_schema_sbas.inc"
#include "formats/sbf_schema_inertial.inc"

#define RECEIVER(id, revision, name, kind, ...)                                                              \
	{                                                                                                    \
		id, revision, SBF_TIME_RECEIVER, name, kind, __VA_ARGS__                                     \
	}
#define SIS(id, revision, name, kind, ...)                                                                   \
	{                                                                                                    \
		id, revision, SBF_TIME_SIS, name, kind, __VA_ARGS__                                          \
	}
#define EXTERNAL(id, revision, name, kind, ...)                                                              \
	{                                                                                                    \
		id, revision, SBF_TIME_EXTERNAL, name, kind, __VA_ARGS__                                     \
	}
#define MARKER(id_, name_)                                                                                   \
	{                                                                                                    \
		.id = (id_), .time = SBF_TIME_RECEIVER, .name = (name_), .kind = NO_RECORD, .size = 14       \
	}
#define NO_RECORD FW_RECORD_COUNT

/* clang-format off */
const fw_sbf_schema fw_sbf_schemas[] = {
	RECEIVER(4000, 3, "MeasExtra", NO_RECORD, 20, FIELDS(meas_extra), GROUPS(meas_extra_groups)),
	RECEIVER(4001, 0, "DOP", FW_dop, 32, FIELDS(dop)),
	SIS(4002, 0, "GALNav", FW_eph_gal, 149, FIELDS(gal_nav)),
	SIS(4004, 1, "GLONav", FW_eph_glo, 97, FIELDS(glo_nav)),
	RECEIVER(4006, 3, "PVTCartesian", FW_pvt_ecef, 95, FIELDS(pvt_cartesian)),
	RECEIVER(4007, 3, "PVTGeodetic", FW_pvt, 95, FIELDS(pvt_geodetic)),
	RECEIVER(4008, 1, "PVTSatCartesian", FW_satpos, 16, FIELDS(counted), GROUPS(sat_pos_groups)),
	RECEIVER(4009, 1, "PVTResiduals", FW_residual, 20, FIELDS(residuals), GROUPS(residuals_groups)),
	RECEIVER(4011, 0, "RAIMStatistics", FW_raim, 34, FIELDS(raim)),
	RECEIVER(4014, 1, "ReceiverStatus", FW_status, 32, FIELDS(receiver_status), GROUPS(receiver_status_groups)),
	SIS(4017, 0, "GPSRawCA", FW_page, 60, FIELDS(raw_lnav)),
	SIS(4018, 0, "GPSRawL2C", FW_page, 60, FIELDS(raw_cnav_l2c)),
	SIS(4019, 0, "GPSRawL5", FW_page, 60, FIELDS(raw_cnav_l5)),
	SIS(4020, 0, "GEORawL1", FW_sbas, 52, FIELDS(raw_sbas_l1)),
	SIS(4021, 0, "GEORawL5", FW_sbas, 52, FIELDS(raw_sbas_l5)),
	SIS(4022, 0, "GALRawFNAV", FW_page, 52, FIELDS(raw_fnav)),
	SIS(4023, 0, "GALRawINAV", FW_page, 52, FIELDS(raw_inav)),
	SIS(4024, 0, "GALRawCNAV", FW_page, 84, FIELDS(raw_cnav_e6)),
	SIS(4026, 0, "GLORawCA", FW_page, 32, FIELDS(raw_glonass)),
	RECEIVER(4027, 1, "MeasEpoch", NO_RECORD, 20, FIELDS(meas_epoch), GROUPS(meas_epoch_groups)),
	RECEIVER(4028, 0, "BaseVectorGeod", FW_base, 16, FIELDS(counted), GROUPS(base_vector_geod_groups)),
	SIS(4030, 0, "GALIon", FW_nequick, 29, FIELDS(gal_ion)),
	SIS(4031, 0, "GALUtc", FW_utc, 37, FIELDS(gal_utc)),
	SIS(4032, 0, "GALGstGps", FW_ggto, 29, FIELDS(gal_gst_gps)),
	SIS(4036, 0, "GLOTime", FW_glo_time, 40, FIELDS(glo_time)),
	EXTERNAL(4037, 3, "ExtEventPVTCartesian", FW_event_pvt_ecef, 95, FIELDS(pvt_cartesian)),
	EXTERNAL(4038, 3, "ExtEventPVTGeodetic", FW_event_pvt, 95, FIELDS(pvt_geodetic)),
	RECEIVER(4043, 0, "BaseVectorCart", FW_base_ecef, 16, FIELDS(counted), GROUPS(base_vector_cart_groups)),
	RECEIVER(4045, 0, "IntPVAAGeod", NO_RECORD, 60, FIELDS(int_pvaa_geod)),
	SIS(4047, 0, "BDSRaw", FW_page, 60, FIELDS(raw_bds)),
	EXTERNAL(4050, 0, "ExtSensorMeas", FW_ext_sensor, 16, FIELDS(counted), GROUPS(ext_sensor_meas_groups)),
	RECEIVER(4057, 2, "ExtSensorSetup", FW_sensor_setup, 16, FIELDS(counted), GROUPS(ext_sensor_setup_groups)),
	SIS(4066, 0, "QZSRawL1CA", FW_page, 60, FIELDS(raw_lnav)),
	SIS(4067, 0, "QZSRawL2C", FW_page, 60, FIELDS(raw_cnav_l2c)),
	SIS(4068, 0, "QZSRawL5", FW_page, 60, FIELDS(raw_cnav_l5)),
	SIS(4069, 0, "QZSRawL6", FW_page, 272, FIELDS(raw_l6)),
	SIS(4081, 0, "BDSNav", FW_eph_bds, 140, FIELDS(bds_nav)),
	RECEIVER(4082, 0, "QualityInd", FW_quality, 16, FIELDS(quality_ind), GROUPS(quality_ind_groups)),
	SIS(4093, 0, "NAVICRaw", FW_page, 60, FIELDS(raw_navic)),
	SIS(4095, 0, "QZSNav", FW_eph_gps, 140, FIELDS(gps_nav)),
	SIS(4120, 0, "BDSIon", FW_klobuchar, 48, FIELDS(klobuchar)),
	SIS(4121, 0, "BDSUtc", FW_utc, 32, FIELDS(bds_utc)),
	EXTERNAL(4216, 0, "ExtEventBaseVectCart", FW_event_base_ecef, 16, FIELDS(counted), GROUPS(base_vector_cart_groups)),
	EXTERNAL(4217, 0, "ExtEventBaseVectGeod", FW_event_base, 16, FIELDS(counted), GROUPS(base_vector_geod_groups)),
	SIS(4218, 0, "BDSRawB1C", FW_page, 248, FIELDS(raw_bds_cnav1)),
	SIS(4219, 0, "BDSRawB2a", FW_page, 92, FIELDS(raw_bds_cnav2)),
	SIS(4221, 0, "GPSRawL1C", FW_page, 248, FIELDS(raw_l1c)),
	RECEIVER(4224, 0, "IMUSetup", FW_imu_setup, 40, FIELDS(imu_setup)),
	RECEIVER(4225, 0, "INSNavCart", FW_ins_ecef, 52, FIELDS(ins_nav_cart), GROUPS(ins_nav_cart_groups)),
	RECEIVER(4226, 0, "INSNavGeod", FW_ins, 56, FIELDS(ins_nav_geod), GROUPS(ins_nav_geod_groups)),
	SIS(4227, 0, "QZSRawL1C", FW_page, 248, FIELDS(raw_l1c)),
	SIS(4228, 0, "QZSRawL1S", FW_page, 52, FIELDS(raw_l1s)),
	EXTERNAL(4229, 0, "ExtEventINSNavCart", FW_event_ins_ecef, 52, FIELDS(ins_nav_cart), GROUPS(ins_nav_cart_groups)),
	EXTERNAL(4230, 0, "ExtEventINSNavGeod", FW_event_ins, 56, FIELDS(ins_nav_geod), GROUPS(ins_nav_geod_groups)),
	EXTERNAL(4237, 0, "ExtEventAttEuler", FW_event_att, 44, FIELDS(att_euler)),
	SIS(4242, 0, "BDSRawB2b", FW_page, 144, FIELDS(raw_bds_cnav3)),
	RECEIVER(4244, 0, "VelSensorSetup", FW_velocity_setup, 28, FIELDS(vel_sensor_setup)),
	SIS(4246, 0, "QZSRawL5S", FW_page, 52, FIELDS(raw_l5s)),
	SIS(4270, 0, "QZSRawL6D", FW_page, 272, FIELDS(raw_l6)),
	SIS(4271, 0, "QZSRawL6E", FW_page, 272, FIELDS(raw_l6)),
	SIS(5891, 0, "GPSNav", FW_eph_gps, 140, FIELDS(gps_nav)),
	SIS(5893, 0, "GPSIon", FW_klobuchar, 48, FIELDS(klobuchar)),
	SIS(5894, 0, "GPSUtc", FW_utc, 37, FIELDS(gps_utc)),
	SIS(5896, 0, "GEONav", FW_eph_sbas, 104, FIELDS(geo_nav)),
	SIS(5897, 0, "GEOAlm", FW_sbas_almanac, 72, FIELDS(geo_alm)),
	RECEIVER(5902, 4, "ReceiverSetup", FW_setup, 424, FIELDS(receiver_setup)),
	RECEIVER(5905, 0, "PosCovCartesian", FW_pvt_ecef, 56, FIELDS(pos_cov_cartesian)),
	RECEIVER(5906, 0, "PosCovGeodetic", FW_pvt, 56, FIELDS(pos_cov_geodetic)),
	RECEIVER(5907, 0, "VelCovCartesian", FW_pvt_ecef, 56, FIELDS(vel_cov_cartesian)),
	RECEIVER(5908, 0, "VelCovGeodetic", FW_pvt, 56, FIELDS(vel_cov_geodetic)),
	RECEIVER(5910, 0, "PVTResiduals", NO_RECORD, 16, FIELDS(counted), GROUPS(residuals_v1_groups)),
	RECEIVER(5914, 0, "ReceiverTime", FW_time, 22, FIELDS(receiver_time)),
	RECEIVER(5915, 0, "RAIMStatistics", FW_raim, 40, FIELDS(raim_v1), GROUPS(raim_v1_groups)),
	SIS(5917, 0, "GEOServiceLevel", FW_sbas_service, 24, FIELDS(geo_service_level), GROUPS(geo_service_level_groups)),
	SIS(5918, 0, "GEONetworkTime", FW_sbas_time, 45, FIELDS(geo_network_time)),
	MARKER(5921, "EndOfPVT"),
	MARKER(5922, "EndOfMeas"),
	EXTERNAL(5924, 1, "ExtEvent", FW_event, 30, FIELDS(ext_event)),
	SIS(5925, 0, "GEOMT00", FW_sbas_mt0, 15, FIELDS(geo_mt00)),
	SIS(5926, 0, "GEOPRNMask", FW_sbas_mask, 17, FIELDS(geo_prn_mask), GROUPS(geo_prn_mask_groups)),
	SIS(5927, 0, "GEOFastCorr", FW_sbas_fast, 20, FIELDS(geo_fast_corr), GROUPS(geo_fast_corr_groups)),
	SIS(5928, 0, "GEOIntegrity", FW_sbas_integrity, 20, FIELDS(geo_integrity), GROUPS(geo_integrity_groups)),
	SIS(5929, 0, "GEOFastCorrDegr", FW_sbas_degradation, 17, FIELDS(geo_fast_corr_degr), GROUPS(geo_fast_corr_degr_groups)),
	SIS(5930, 0, "GEODegrFactors", FW_sbas_factors, 112, FIELDS(geo_degr_factors)),
	SIS(5931, 0, "GEOIGPMask", FW_sbas_igp_mask, 19, FIELDS(geo_igp_mask), GROUPS(geo_igp_mask_groups)),
	SIS(5932, 0, "GEOLongTermCorr", FW_sbas_long, 20, FIELDS(geo_long_term_corr), GROUPS(geo_long_term_corr_groups)),
	SIS(5933, 0, "GEOIonoDelay", FW_sbas_iono, 20, FIELDS(geo_iono_delay), GROUPS(geo_iono_delay_groups)),
	SIS(5934, 0, "GEOClockEphCovMatrix", FW_sbas_cov, 20, FIELDS(geo_clock_eph_cov), GROUPS(geo_clock_eph_cov_groups)),
	RECEIVER(5935, 0, "GEOCorrections", FW_sbas_corr, 16, FIELDS(counted), GROUPS(geo_corrections_groups)),
	RECEIVER(5936, 0, "Comment", FW_comment, 16, FIELDS(comment), GROUPS(comment_groups)),
	RECEIVER(5938, 0, "AttEuler", FW_att, 44, FIELDS(att_euler)),
	RECEIVER(5939, 0, "AttCovEuler", FW_att, 40, FIELDS(att_cov_euler)),
	RECEIVER(5942, 0, "AuxAntPositions", FW_aux_ant, 16, FIELDS(counted), GROUPS(aux_ant_groups)),
	MARKER(5943, "EndOfAtt"),
	SIS(5958, 0, "SBASL5Nav", FW_sbas5_nav, 92, FIELDS(sbas_l5_nav)),
	SIS(5959, 0, "SBASL5Alm", FW_sbas5_almanac, 52, FIELDS(sbas_l5_alm)),
};

const int fw_sbf_n_schemas = sizeof fw_sbf_schemas / sizeof fw_sbf_schemas[0];

/* Blocks that furrow knows by name only, ascending. */
static const struct {
	uint16_t id;
	const char *name;
} named[] = {
	{4003, "GALAlm"}, {4005, "GLOAlm"}, {4010, "TURHPCAInfo"}, {4012, "SatVisibility"}, {4013, "ChannelStatus"},
	{4015, "Commands"}, {4016, "CorrPeakSample"}, {4025, "GALRawGNAV"}, {4029, "GALRawGNAVe"},
	{4033, "GALIntegrity"}, {4034, "GALSARRLM"}, {4035, "TURPVTSatCorrections"}, {4039, "SysTimeOffset"},
	{4040, "BBSamples"}, {4041, "TURStatus"}, {4042, "GPSCNav"}, {4044, "PosCart"}, {4046, "IQCorr"},
	{4049, "RTCMDatum"}, {4051, "BluetoothStatus"}, {4052, "PosLocal"}, {4053, "NTRIPClientStatus"},
	{4054, "WiFiAPStatus"}, {4055, "CellularStatus"}, {4056, "ExtSensorStatus"}, {4058, "IPStatus"},
	{4059, "DiskStatus"}, {4060, "IntPVCart"}, {4061, "IntPVGeod"}, {4062, "IntPosCovCart"},
	{4063, "IntVelCovCart"}, {4064, "IntPosCovGeod"}, {4065, "IntVelCovGeod"}, {4070, "IntAttEuler"},
	{4072, "IntAttCovEuler"}, {4075, "ASCIIIn"}, {4076, "PVTSupport"}, {4079, "PVTSupportA"},
	{4080, "TURFormat"}, {4083, "BatteryStatus"}, {4084, "RxComponents"}, {4085, "UHFStatus"}, {4086, "ISMR"},
	{4087, "SQMSamples"}, {4088, "GNSSNavBits"}, {4089, "RIMSHealth"}, {4090, "InputLink"},
	{4091, "OutputLink"}, {4092, "RFStatus"}, {4094, "PosProjected"}, {4096, "WiFiClientStatus"},
	{4097, "EncapsulatedOutput"}, {4098, "MeasFullRange"}, {4099, "GNSSSymbols"}, {4100, "CorrValues"},
	{4101, "PowerStatus"}, {4102, "LogStatus"}, {4103, "RxMessage"}, {4105, "DynDNSStatus"},
	{4106, "GISAction"}, {4107, "GISStatus"}, {4108, "GALNavMonitor"}, {4109, "Meas3Ranges"},
	{4110, "Meas3CN0HiRes"}, {4111, "Meas3Doppler"}, {4112, "Meas3PP"}, {4113, "Meas3MP"}, {4116, "QZSAlm"},
	{4119, "BDSAlm"}, {4122, "NTRIPServerStatus"}, {4200, "LBandReceiverStatus"}, {4201, "LBandTrackerStatus"},
	{4202, "LBAS1DecoderStatus"}, {4203, "LBAS1Messages"}, {4204, "LBandBeams"}, {4211, "FugroDDS"},
	{4212, "LBandRaw"}, {4214, "FugroStatus"}, {4215, "CalibrationValues"}, {4220, "MultipathMonitor"},
	{4222, "ExtSensorInfo"}, {4223, "ExtSensorStatus"}, {4232, "PVTGeodeticAuth"}, {4238, "P2PPStatus"},
	{4241, "IMUBias"}, {4245, "GALAuthStatus"}, {4250, "ImuRawSamples"}, {4251, "BDSCNav1"}, {4252, "BDSCNav2"},
	{4253, "BDSCNav3"}, {4254, "NavICLNav"}, {4272, "NavCart"}, {4275, "NavGeod"}, {5892, "GPSAlm"},
	{5895, "GPSRaw"}, {5898, "GEORaw"}, {5903, "PVTCartesian"}, {5904, "PVTGeodetic"}, {5909, "DOP"},
	{5911, "xPPSOffset"}, {5912, "TrackingStatus"}, {5913, "ReceiverStatus"}, {5919, "DiffCorrIn"},
	{5940, "AttQuat"}, {5941, "AttCovQuat"}, {5944, "GenMeasEpoch"}, {5947, "CNAVRaw"}, {5948, "BaseLink"},
	{5949, "BaseStation"}, {5950, "BaseLine"},
};
/* clang-format on */

const fw_sbf_schema *fw_sbf_schema_find(uint16_t id)
{
	int low = 0, high = fw_sbf_n_schemas;
	while (low < high) {
		int middle = (low + high) / 2;
		if (fw_sbf_schemas[middle].id < id)
			low = middle + 1;
		else
			high = middle;
	}
	return low < fw_sbf_n_schemas && fw_sbf_schemas[low].id == id ? &fw_sbf_schemas[low] : NULL;
}

const char *fw_sbf_block_name(uint16_t id)
{
	const fw_sbf_schema *schema = fw_sbf_schema_find(id);
	if (schema)
		return schema->name;
	for (size_t i = 0; i < sizeof named / sizeof named[0]; i++)
		if (named[i].id == id)
			return named[i].name;
	return "";
}
