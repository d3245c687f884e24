#include "base/status.h"

const char *fw_status_text(fw_status status)
{
	switch (status) {
	case FW_OK: return "done";
	case FW_EOF: return "end of input";
	case FW_DUBIOUS: return "dubious: outside the range of the source";
	case FW_MORE: return "more input needed";
	case FW_EINVAL: return "invalid argument";
	case FW_ENONFINITE: return "not a finite number";
	case FW_ERANGE: return "out of range";
	case FW_ESINGULAR: return "matrix is singular";
	case FW_ENOCONV: return "no convergence";
	case FW_ESYNTAX: return "syntax error";
	case FW_EFORMAT: return "format error";
	case FW_ECHECKSUM: return "checksum mismatch";
	case FW_ETRUNCATED: return "cut short";
	case FW_EUNKNOWN: return "unknown";
	case FW_ENOMEM: return "out of memory";
	case FW_EIO: return "input/output error";
	case FW_ENOSPACE: return "buffer too small";
	}
	return "unknown status";
}
