/* How a vehicle moves at one moment: what the trajectory gives and everything else in the simulator takes. */
#ifndef FURROW_SIM_MOTION_H
#define FURROW_SIM_MOTION_H

/* Body frame FRD (forward, right, down), local frame NED, Earth-centred frame ECEF (WGS84). C_n_b: x_n = C_n_b x_b. */
typedef struct {
	double t_s;                        /* time since the start of the scenario */
	double lat_rad, lon_rad, height_m; /* of the reference point of the body, ellipsoidal height */
	double position_ecef_m[3];
	double velocity_ned_mps[3]; /* relative to the Earth */
	double velocity_ecef_mps[3];
	double acceleration_ned_mps2[3]; /* d(velocity_ned)/dt as seen in NED */
	double C_n_b[3][3];
	double roll_rad, pitch_rad, heading_rad; /* Z-Y-X; heading 0..2 pi */
	double omega_ib_b_radps
	    [3]; /* angular rate of the body against inertial space, body axes: what a gyro sees */
	double force_b_mps2[3]; /* specific force, body axes: what an accelerometer sees */
} fw_motion;

#endif
