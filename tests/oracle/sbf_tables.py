"""The fields of SBF blocks by offset, for test_schema.py: from the SBF reference guides, independently of furrow's own
tables. What the lines mean is said in sbf_random.py."""

PVT = """
14 u1 mode bits0-3
14 u1 auto_base bit6
14 u1 two_d bit7
15 u1 error any
40 f4 undulation_m
56 f4 course_deg
60 f8 clock_bias_s 0.001
68 f4 clock_drift_ppm
72 u1 time_system
73 u1 datum
74 u1 n_sats
75 u1 wa_corr any
76 u2 reference_id
78 u2 corr_age_s 0.01
80 u4 signals any
84 u1 alert any
85 u1 n_bases any r1
86 u2 ppp_info any r1
88 u2 latency_s 0.0001 r2
90 u2 h_accuracy_m 0.01 r2
92 u2 v_accuracy_m 0.01 r2
94 u1 misc any r2
"""

GEODETIC = """
16 f8 lat_deg deg
24 f8 lon_deg deg
32 f8 height_m
44 f4 vn_mps
48 f4 ve_mps
52 f4 vd_mps -1
"""

CARTESIAN = """
16 f8 x_m
24 f8 y_m
32 f8 z_m
44 f4 vx_mps
48 f4 vy_mps
52 f4 vz_mps
"""

ATTITUDE = """
14 u1 n_sats
15 u1 error_aux1 bits0-1
15 u1 error_aux2 bits2-3
15 u1 not_requested bit7
16 u2 mode max=4
20 f4 heading_deg
24 f4 pitch_deg
28 f4 roll_deg
32 f4 pitchrate_degps
36 f4 rollrate_degps
40 f4 headingrate_degps
"""

BASE = """
0 u1 n_sats
1 u1 error any
2 u1 mode bits0-3
3 u1 misc any
40 u2 azimuth_deg 0.01
42 i2 elevation_deg 0.01
44 u2 reference_id
46 u2 corr_age_s 0.01
48 u4 signals any
"""

BASE_LOCAL = """
4 f8 east_m
12 f8 north_m
20 f8 up_m
28 f4 ve_mps
32 f4 vn_mps
36 f4 vu_mps
"""

BASE_ECEF = """
4 f8 dx_m
12 f8 dy_m
20 f8 dz_m
28 f4 vx_mps
32 f4 vy_mps
36 f4 vz_mps
"""

# The tail that the ephemerides of GPS, QZSS and BeiDou share.
KEPLER = """
32 u4 toc_s
36 f4 af2_sps2
40 f4 af1_sps
44 f4 af0_s
48 f4 crs_m
52 f4 deltan_radps pi
56 f8 m0_rad pi
64 f4 cuc_rad
68 f8 ecc
76 f4 cus_rad
80 f8 sqrt_a_sqrtm
88 u4 toe_s
92 f4 cic_rad
96 f8 omega0_rad pi
104 f4 cis_rad
108 f8 i0_rad pi
116 f4 crc_m
120 f8 omega_rad pi
128 f4 omegadot_radps pi
132 f4 idot_radps pi
136 u2 toc_week
138 u2 toe_week
"""

GPS_LIKE = """
16 u2 week
18 u1 code_on_l2
19 u1 ura
20 u1 health
21 u1 l2p_data
22 u2 iodc
24 u1 iode2
25 u1 iode3
26 u1 fit
28 f4 tgd_s
"""

KLOBUCHAR = """
16 f4 alpha0_s
20 f4 alpha1_s
24 f4 alpha2_s
28 f4 alpha3_s
32 f4 beta0_s
36 f4 beta1_s
40 f4 beta2_s
44 f4 beta3_s
"""

UTC = """
16 f4 a1_sps
20 f8 a0_s
28 u4 tot_s
32 u1 wnt
33 i1 leap_s
34 u1 wnlsf
35 u1 dn
36 i1 leap_future_s
"""

TABLES = f"""
record dop, block 4001
14 u1 n_sats
16 u2 pdop 0.01 dnu=0
18 u2 tdop 0.01 dnu=0
20 u2 hdop 0.01 dnu=0
22 u2 vdop 0.01 dnu=0
24 f4 hpl_m
28 f4 vpl_m

record event_pvt, block 4038 88 88 96 96
{PVT}{GEODETIC}
record event_pvt_ecef, block 4037 88 88 96 96
{PVT}{CARTESIAN}
record event_att, block 4237
{ATTITUDE}

record base, block 4028
sub 14 15 16 52
{BASE}{BASE_LOCAL}
record base_ecef, block 4043
sub 14 15 16 52
{BASE}{BASE_ECEF}
record event_base, block 4217
sub 14 15 16 52
{BASE}{BASE_LOCAL}
record event_base_ecef, block 4216
sub 14 15 16 52
{BASE}{BASE_ECEF}

record aux_ant, block 5942
sub 14 15 16 52
0 u1 n_sats
1 u1 error any
2 u1 ambiguity max=1
3 u1 aux_antenna any max=2
4 f8 east_m
12 f8 north_m
20 f8 up_m
28 f8 ve_mps
36 f8 vn_mps
44 f8 vu_mps

record satpos, block 4008 16 16
sub 14 15 16 48
0 u1 sat sat
1 u1 glonass_channel glo
2 u2 iode
4 f8 x_m
12 f8 y_m
20 f8 z_m
28 f4 vx_mps
32 f4 vy_mps
36 f4 vz_mps
46 u1 iono_model r1

record raim, block 4011
14 u1 integrity max=2
16 f4 pos_herl_m
20 f4 pos_verl_m
24 f4 vel_herl_mps
28 f4 vel_verl_mps
32 u2 overall_model 0.00002

record quality, block 4082
sub 14 - 16 2
0 u2 indicator bits0-7
0 u2 value bits8-11

record time, block 5914
14 i1 utc_year
15 i1 utc_month
16 i1 utc_day
17 i1 utc_hour
18 i1 utc_min
19 i1 utc_sec
20 i1 leap_s
21 u1 sync any

record status, block 4014 32 32
14 u1 cpu_load_pct
15 u1 ext_error any
16 u4 uptime_s any
20 u4 rx_state any
24 u4 rx_error any
30 u1 command_count any r1
31 u1 temperature_degc celsius dnu=0 r1
sub 28 29 32 4
0 u1 front_end bits0-4
0 u1 antenna bits5-7
1 i1 gain_db
2 u1 sample_var any
3 u1 blanking_pct any

record setup, block 5902 268 288 328 368 424
16 c60 marker_name text
76 c20 marker_number text
96 c20 observer text
116 c40 agency text
156 c20 rx_serial text
176 c20 rx_name text
196 c20 rx_version text
216 c20 ant_serial text
236 c20 ant_type text
256 f4 delta_h_m
260 f4 delta_e_m
264 f4 delta_n_m
268 c20 marker_type text r1
288 c40 firmware text r2
328 c40 product text r3
368 f8 lat_deg deg r4
376 f8 lon_deg deg r4
384 f4 height_m r4
388 c10 station_code text r4
398 u1 monument any r4
399 u1 receiver any r4
400 c3 country text r4

record imu_setup, block 4224
15 u1 port any
16 f4 lever_x_m
20 f4 lever_y_m
24 f4 lever_z_m
28 f4 theta_x_deg
32 f4 theta_y_deg
36 f4 theta_z_deg

record velocity_setup, block 4244
15 u1 port any
16 f4 lever_x_m
20 f4 lever_y_m
24 f4 lever_z_m

"""

# Navigation messages: what a satellite sends has no mark for "not available" but in the reals.
NAVIGATION = f"""
record eph_gps, block 5891
14 u1 sat sat:G
{GPS_LIKE}{KEPLER}
record eph_gps, block 4095
14 u1 sat sat:J
{GPS_LIKE}{KEPLER}
record eph_bds, block 4081
14 u1 sat sat:C
16 u2 week
18 u1 ura
19 u1 health
20 u1 aodc
21 u1 aode
24 f4 tgd1_s
28 f4 tgd2_s
{KEPLER}

record eph_gal, block 4002 152
14 u1 sat sat:E
15 u1 message max=16
16 f8 sqrt_a_sqrtm
24 f8 m0_rad pi
32 f8 ecc
40 f8 i0_rad pi
48 f8 omega_rad pi
56 f8 omega0_rad pi
64 f4 omegadot_radps pi
68 f4 idot_radps pi
72 f4 deltan_radps pi
76 f4 cuc_rad
80 f4 cus_rad
84 f4 crc_m
88 f4 crs_m
92 f4 cic_rad
96 f4 cis_rad
100 u4 toe_s
104 u4 toc_s
108 f4 af2_sps2
112 f4 af1_sps
116 f8 af0_s
124 u2 toe_week
126 u2 toc_week
128 u2 iodnav
130 u2 health any
132 u1 health_prs any
133 u1 sisa_e1e5a
134 u1 sisa_e1e5b
135 u1 sisa_e1e6a
136 f4 bgd_e1e5a_s
140 f4 bgd_e1e5b_s
144 f4 bgd_e1e6a_s
148 u1 cnav_enc

record eph_glo, block 4004 96 100
14 u1 sat sat:R
15 u1 glonass_channel glo
16 f8 x_m 1000
24 f8 y_m 1000
32 f8 z_m 1000
40 f4 vx_mps 1000
44 f4 vy_mps 1000
48 f4 vz_mps 1000
52 f4 ax_mps2 1000
56 f4 ay_mps2 1000
60 f4 az_mps2 1000
64 f4 gamma
68 f4 tau_s
72 f4 dtau_s
76 u4 toe_s
80 u2 toe_week
82 u1 p1_min
83 u1 p2
84 u1 age_days
85 u1 health_b
86 u2 tb_min
88 u1 m
89 u1 p
90 u1 l
91 u1 p4
92 u2 nt_day
94 u2 accuracy_m 0.01
96 u1 health_c r1

record glo_time, block 4036
14 u1 sat sat:R
15 u1 glonass_channel glo
16 u1 n4
17 u1 kp
18 u2 day
20 f4 tau_gps_s
24 f8 tau_c_s
32 f4 b1_s
36 f4 b2_s

record klobuchar, block 5893
14 u1 sat sat:G
{KLOBUCHAR}
record klobuchar, block 4120
14 u1 sat sat:C
{KLOBUCHAR}
record nequick, block 4030
14 u1 sat sat:E
15 u1 message max=16
16 f4 ai0_sfu
20 f4 ai1_sfu
24 f4 ai2_sfu
28 u1 storm any

record utc, block 5894
14 u1 sat sat:G
{UTC}
record utc, block 4031
14 u1 sat sat:E
15 u1 message max=16
{UTC}
record utc, block 4121
14 u1 sat sat:C
16 f4 a1_sps
20 f8 a0_s
28 i1 leap_s
29 u1 wnlsf
30 u1 dn
31 i1 leap_future_s

record ggto, block 4032
14 u1 sat sat:E
15 u1 message max=16
16 f4 a1_sps
20 f4 a0_s
24 u4 tot_s
28 u1 wnt

record eph_sbas, block 5896
14 u1 sat sat:S
16 u2 iodn
18 u2 ura
20 u4 t0_s
24 f8 x_m
32 f8 y_m
40 f8 z_m
48 f8 vx_mps
56 f8 vy_mps
64 f8 vz_mps
72 f8 ax_mps2
80 f8 ay_mps2
88 f8 az_mps2
96 f4 agf0_s
100 f4 agf1_sps

record sbas_mt0, block 5925
14 u1 sat sat:S

record sbas_mask, block 5926
14 u1 sat sat:S
15 u1 iodp
sub 16 - 17 1
0 u1 mask_sat sat

record sbas_fast, block 5927
14 u1 sat sat:S
15 u1 type
16 u1 iodp
17 u1 iodf
sub 18 19 20 8
0 u1 mask_no
1 u1 udrei
4 f4 prc_m

record sbas_factors, block 5930
14 u1 sat sat:S
16 f8 brrc_m
24 f8 cltc_lsb_m
32 f8 cltc_v1_mps
40 u4 iltc_v1_s
44 f8 cltc_v0_m
52 u4 iltc_v0_s
56 f8 cgeo_lsb_m
64 f8 cgeo_v_mps
72 u4 igeo_s
76 f4 cer_m
80 f8 ciono_step_m
88 u4 iiono_s
92 f8 ciono_ramp_mps
100 u1 rss_udre max=1
101 u1 rss_iono max=1
104 f8 ccovariance

record sbas_time, block 5918
14 u1 sat sat:S
16 f4 a1_sps
20 f8 a0_s
28 u4 tot_s
32 u1 wnt
33 i1 leap_s
34 u1 wnlsf
35 u1 dn
36 i1 leap_future_s
37 u1 utc_std
38 u2 gps_wn
40 u4 gps_tow_s
44 u1 glonass_id

record sbas_almanac, block 5897
14 u1 sat sat:S
16 u1 data_id
18 u2 health any
20 u4 toa_s max=2147483647
24 f8 x_m
32 f8 y_m
40 f8 z_m
48 f8 vx_mps
56 f8 vy_mps
64 f8 vz_mps

record sbas_igp_mask, block 5931
14 u1 sat sat:S
15 u1 bands
16 u1 band
17 u1 iodi
sub 18 - 19 1
0 u1 igp

record sbas_long, block 5932
14 u1 sat sat:S
sub 15 16 20 40
0 u1 velocity_code
1 u1 mask_no
2 u1 iodp
3 u1 iode
4 f4 dx_m
8 f4 dy_m
12 f4 dz_m
16 f4 vx_mps
20 f4 vy_mps
24 f4 vz_mps
28 f4 daf0_s
32 f4 daf1_sps
36 u4 toe_s

record sbas_iono, block 5933
14 u1 sat sat:S
15 u1 band
16 u1 iodi
sub 17 18 20 8
0 u1 mask_no
1 u1 givei
4 f4 delay_m

record sbas_service, block 5917
14 u1 sat sat:S
16 u1 iods
17 u1 messages
18 u1 message_no
19 u1 priority
20 u1 dudre_in
21 u1 dudre_out
sub 22 23 24 8
0 i1 lat1_deg
1 i1 lat2_deg
2 i2 lon1_deg
4 i2 lon2_deg
6 u1 shape

record sbas_cov, block 5934
14 u1 sat sat:S
15 u1 iodp
sub 16 17 20 24
0 u1 mask_no
3 u1 scale_exp
4 u2 e11
6 u2 e22
8 u2 e33
10 u2 e44
12 i2 e12
14 i2 e13
16 i2 e14
18 i2 e23
20 i2 e24
22 i2 e34

record sbas_corr, block 5935
sub 14 15 16 64
0 u1 sat sat:S
1 u1 iode
4 f4 prc_m
8 f4 fast_age_s
12 f4 dx_m
16 f4 dy_m
20 f4 dz_m
24 f4 dclock_m
28 f4 long_age_s
32 f4 ipp_lat_rad
36 f4 ipp_lon_rad
40 f4 iono_m
44 f4 iono_age_s
48 f4 var_flt_m2
52 f4 var_uire_m2
56 f4 var_air_m2
60 f4 var_tropo_m2

record sbas5_nav, block 5958
14 u1 sat sat:S
15 u1 iodg
16 u1 provider
20 f4 cuc_rad
24 f4 cus_rad
28 f4 idot_radps pi
32 f8 omega_rad pi
40 f8 omega0_rad pi
48 f8 m0_rad pi
56 f4 af1_sps
60 f4 af0_s
64 f8 i0_rad pi
72 f8 ecc
80 f8 a_m
88 u4 toe_s

record sbas5_almanac, block 5959
14 u1 sat sat:S
15 u1 provider
18 u1 broadcast
20 f4 omega_rad pi
24 f4 omega0_rad pi
28 f4 omegadot_radps pi
32 f4 m0_rad pi
36 f4 i0_rad pi
40 f4 ecc
44 f4 a_m
48 u4 toa_s
"""

JOINED = f"""
record pvt, block 4007 88 88 96 96
{PVT}{GEODETIC}
record pvt, block 5906
16 f4 cov_nn_m2
16 f4 sd_n_m sqrt
20 f4 cov_ee_m2
20 f4 sd_e_m sqrt
24 f4 cov_dd_m2
24 f4 sd_d_m sqrt
28 f4 cov_bb_m2
32 f4 cov_ne_m2
36 f4 cov_nd_m2 -1
40 f4 cov_nb_m2
44 f4 cov_ed_m2 -1
48 f4 cov_eb_m2
52 f4 cov_db_m2 -1
record pvt, block 5908
16 f4 cov_vnvn_m2ps2
20 f4 cov_veve_m2ps2
24 f4 cov_vdvd_m2ps2
28 f4 cov_ff_m2ps2
32 f4 cov_vnve_m2ps2
36 f4 cov_vnvd_m2ps2 -1
40 f4 cov_vnf_m2ps2
44 f4 cov_vevd_m2ps2 -1
48 f4 cov_vef_m2ps2
52 f4 cov_vdf_m2ps2 -1

record pvt_ecef, block 4006 88 88 96 96
{PVT}{CARTESIAN}
record pvt_ecef, block 5905
16 f4 cov_xx_m2
20 f4 cov_yy_m2
24 f4 cov_zz_m2
28 f4 cov_bb_m2
32 f4 cov_xy_m2
36 f4 cov_xz_m2
40 f4 cov_xb_m2
44 f4 cov_yz_m2
48 f4 cov_yb_m2
52 f4 cov_zb_m2
record pvt_ecef, block 5907
16 f4 cov_vxvx_m2ps2
20 f4 cov_vyvy_m2ps2
24 f4 cov_vzvz_m2ps2
28 f4 cov_ff_m2ps2
32 f4 cov_vxvy_m2ps2
36 f4 cov_vxvz_m2ps2
40 f4 cov_vxf_m2ps2
44 f4 cov_vyvz_m2ps2
48 f4 cov_vyf_m2ps2
52 f4 cov_vzf_m2ps2

record att, block 5938
{ATTITUDE}
record att, block 5939
16 f4 cov_hh_deg2
16 f4 sd_heading_deg sqrt
20 f4 cov_pp_deg2
20 f4 sd_pitch_deg sqrt
24 f4 cov_rr_deg2
24 f4 sd_roll_deg sqrt
28 f4 cov_hp_deg2
32 f4 cov_hr_deg2
36 f4 cov_pr_deg2
"""

# INSNavGeod and INSNavCart: what comes first, then groups of three f4, one for each bit of SBList.
INS = """
14 u1 mode bits0-3
14 u1 att_mode bits4-7
15 u1 error any
16 u2 info any
18 u2 gnss_age_s 0.01
"""
INS_GEODETIC = f"""{INS}
20 f8 lat_deg deg
28 f8 lon_deg deg
36 f8 height_m
44 f4 undulation_m
48 u2 accuracy_m 0.01
50 u2 latency_s 0.0001
52 u1 datum
"""
INS_CARTESIAN = f"""{INS}
20 f8 x_m
28 f8 y_m
36 f8 z_m
44 u2 accuracy_m 0.01
46 u2 latency_s 0.0001
48 u1 datum
"""
INS_ATTITUDE = ["heading_deg", "pitch_deg", "roll_deg"]
INS_ATTITUDE_SD = ["sd_heading_deg", "sd_pitch_deg", "sd_roll_deg"]
INS_ATTITUDE_COVARIANCE = ["cov_hp_deg2", "cov_hr_deg2", "cov_pr_deg2"]
INS_GEODETIC_GROUPS = [
    ["sd_n_m", "sd_e_m", "sd_d_m"],
    INS_ATTITUDE,
    INS_ATTITUDE_SD,
    ["ve_mps", "vn_mps", "vd_mps -1"],
    ["sd_ve_mps", "sd_vn_mps", "sd_vd_mps"],
    ["cov_ne_m2", "cov_nd_m2 -1", "cov_ed_m2 -1"],
    INS_ATTITUDE_COVARIANCE,
    ["cov_vnve_m2ps2", "cov_vevd_m2ps2 -1", "cov_vnvd_m2ps2 -1"],
]
INS_CARTESIAN_GROUPS = [
    ["sd_x_m", "sd_y_m", "sd_z_m"],
    INS_ATTITUDE,
    INS_ATTITUDE_SD,
    ["vx_mps", "vy_mps", "vz_mps"],
    ["sd_vx_mps", "sd_vy_mps", "sd_vz_mps"],
    ["cov_xy_m2", "cov_xz_m2", "cov_yz_m2"],
    INS_ATTITUDE_COVARIANCE,
    ["cov_vxvy_m2ps2", "cov_vxvz_m2ps2", "cov_vyvz_m2ps2"],
]

# Signal number: RINEX code and carrier frequency in Hz; GLONASS also the distance of two channels.
SIGNALS = {
    0: ("1C", 1575.42e6), 1: ("1W", 1575.42e6), 2: ("2W", 1227.6e6), 3: ("2L", 1227.6e6), 4: ("5Q", 1176.45e6),
    5: ("1L", 1575.42e6), 6: ("1C", 1575.42e6), 7: ("2L", 1227.6e6), 8: ("1C", 1602e6, 562500), 9: ("1P", 1602e6, 562500),
    10: ("2P", 1246e6, 437500), 11: ("2C", 1246e6, 437500), 12: ("3Q", 1202.025e6), 13: ("1P", 1575.42e6),
    14: ("5P", 1176.45e6), 15: ("5A", 1176.45e6), 17: ("1C", 1575.42e6), 19: ("6C", 1278.75e6), 20: ("5Q", 1176.45e6),
    21: ("7Q", 1207.14e6), 22: ("8Q", 1191.795e6), 24: ("1C", 1575.42e6), 25: ("5I", 1176.45e6), 26: ("5Q", 1176.45e6),
    28: ("2I", 1561.098e6), 29: ("7I", 1207.14e6), 30: ("6I", 1268.52e6), 32: ("1L", 1575.42e6), 33: ("1Z", 1575.42e6),
    34: ("7D", 1207.14e6), 38: ("1E", 1575.42e6), 39: ("5P", 1176.45e6),
}  # fmt: skip
SIGNALS_OF = {
    "G": [0, 1, 2, 3, 4, 5], "R": [8, 9, 10, 11, 12], "E": [17, 19, 20, 21, 22], "S": [24, 25],
    "C": [13, 14, 28, 29, 30, 34], "J": [6, 7, 26, 32, 33, 38, 39], "I": [15],
}  # fmt: skip

# Block of raw navigation pages: satellites, words, name of the message.
PAGES = {
    4017: ("G", 10, "LNAV"), 4018: ("G", 10, "CNAV_L2C"), 4019: ("G", 10, "CNAV_L5"), 4026: ("R", 3, "GLONASS"),
    4022: ("E", 8, "FNAV"), 4023: ("E", 8, "INAV"), 4024: ("E", 16, "CNAV_E6"), 4047: ("C", 10, "BDS"),
    4066: ("J", 10, "LNAV"), 4067: ("J", 10, "CNAV_L2C"), 4068: ("J", 10, "CNAV_L5"), 4093: ("I", 10, "NAVIC"),
}  # fmt: skip
