/* Status values: what every furrow function that can fail returns.
 *
 *   0    done
 *   > 0  done, with a remark (the outputs are valid)
 *   < 0  not done; the outputs are untouched unless the function says otherwise
 *
 * A status must not be dropped: functions that return one are marked FW_MUST_CHECK. */
#ifndef FURROW_BASE_STATUS_H
#define FURROW_BASE_STATUS_H

#define FW_MUST_CHECK __attribute__((warn_unused_result))

typedef enum {
	FW_OK = 0,

	/* Done, with a remark. */
	FW_EOF = 1,     /* no more input; nothing was produced, nothing was lost */
	FW_DUBIOUS = 2, /* done, but outside the range that the source covers (stale leap-second table) */
	FW_MORE = 3,    /* more input is needed before anything can be produced */

	/* Not done. */
	FW_EINVAL = -1,     /* an argument is outside its documented range */
	FW_ENONFINITE = -2, /* a number is NaN or infinite */
	FW_ERANGE = -3,     /* the result does not fit its type or its table */
	FW_ESINGULAR = -4,  /* a matrix is singular or not positive definite */
	FW_ENOCONV = -5,    /* an iteration did not converge */
	FW_ESYNTAX = -6,    /* text that is not what it should be */
	FW_EFORMAT = -7,    /* bytes that are not what they should be */
	FW_ECHECKSUM = -8,  /* checksum, CRC or parity does not match */
	FW_ETRUNCATED = -9, /* the input ends inside a unit */
	FW_EUNKNOWN = -10,  /* a block, message, type or column that furrow does not know */
	FW_ENOMEM = -11,    /* out of memory */
	FW_EIO = -12,       /* the operating system refused a read, write, open, close or rename */
	FW_ENOSPACE = -13   /* the caller's buffer is too small */
} fw_status;

/* The meaning of a status in a few words of English, for messages ("checksum mismatch").
 * Never NULL: a value that is no fw_status gives "unknown status". */
const char *fw_status_text(fw_status status);

#endif
