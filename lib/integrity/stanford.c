#include "integrity/stanford.h"

fw_stanford fw_stanford_class(double error, double pl, double al)
{
	if (!(pl <= al))
		return error <= pl ? FW_UNAVAILABLE : FW_UNAVAILABLE_MISLEADING;
	if (error <= pl)
		return FW_NOMINAL;
	return error <= al ? FW_MISLEADING : FW_HAZARDOUS;
}
