#include "integrity/state_machine.h"

const char *fw_integrity_state_name(fw_integrity_state state)
{
	switch (state) {
	case FW_RELIABLE: return "RELIABLE";
	case FW_NO_SBAS: return "NO_SBAS";
	case FW_UNRELIABLE: return "UNRELIABLE";
	case FW_NO_POSITION: return "NO_POSITION";
	case FW_INTEGRITY_UNKNOWN: break;
	}
	return "";
}

const char *fw_integrity_cause_name(fw_integrity_cause cause)
{
	switch (cause) {
	case FW_CAUSE_WITHIN_LIMITS: return "within-limits";
	case FW_CAUSE_NO_SBAS: return "no-sbas";
	case FW_CAUSE_NO_LEVELS: return "no-levels";
	case FW_CAUSE_MARGIN: return "margin";
	case FW_CAUSE_HPL: return "hpl";
	case FW_CAUSE_VPL: return "vpl";
	case FW_CAUSE_HPL_VPL: return "hpl-vpl";
	case FW_CAUSE_NO_POSITION: return "no-position";
	case FW_CAUSE_TIMEOUT: return "timeout";
	}
	return "";
}

fw_status fw_integrity_init(const fw_integrity_rules *rules, fw_integrity *m)
{
	if (!(rules->hal_m > 0) || !(rules->val_m > 0) || !(rules->margin >= 0 && rules->margin < 1) ||
	    rules->hold_ns < 0 || rules->alert_ns < 0 || rules->timeout_ns <= 0)
		return FW_EINVAL;
	*m = (fw_integrity){.state = FW_NO_POSITION, .rules = *rules};
	fw_integrity_restart(m);
	return FW_OK;
}

/* Levels that are within the limits, but not by the margin, are not enough to become RELIABLE and no reason to cease. */
static fw_integrity_state judge_margin(const fw_integrity *m, const fw_integrity_epoch *e,
                                       fw_integrity_cause *cause)
{
	const double part = 1 - m->rules.margin;
	*cause = FW_CAUSE_WITHIN_LIMITS;
	if (m->state == FW_RELIABLE ||
	    (e->hpl_m <= part * m->rules.hal_m && e->vpl_m <= part * m->rules.val_m))
		return FW_RELIABLE;
	*cause = FW_CAUSE_MARGIN;
	return m->state == FW_UNRELIABLE ? FW_UNRELIABLE : FW_NO_SBAS;
}

/* The state that an epoch by itself stands for. */
static fw_integrity_state judge(const fw_integrity *m, const fw_integrity_epoch *e, fw_integrity_cause *cause)
{
	*cause = FW_CAUSE_NO_POSITION;
	if (!e->position)
		return FW_NO_POSITION;
	*cause = FW_CAUSE_NO_SBAS;
	if (!e->sbas)
		return FW_NO_SBAS;
	*cause = FW_CAUSE_NO_LEVELS;
	if (!(e->hpl_m > 0 && e->vpl_m > 0))
		return FW_NO_SBAS;
	const bool h = e->hpl_m <= m->rules.hal_m, v = e->vpl_m <= m->rules.val_m;
	*cause = !h && !v ? FW_CAUSE_HPL_VPL : !h ? FW_CAUSE_HPL : FW_CAUSE_VPL;
	return h && v ? judge_margin(m, e, cause) : FW_UNRELIABLE;
}

static void change(fw_integrity *m, fw_time time, fw_integrity_state to, fw_integrity_cause cause,
                   fw_transition *transition)
{
	*transition = (fw_transition){time, m->state, to, cause};
	m->state = to;
	m->changed = time;
	m->trend = 0;
}

bool fw_integrity_expire(fw_integrity *m, fw_time now, fw_transition *transition)
{
	if (!m->begun)
		return false;
	const fw_time alert = fw_time_add_ns(m->since, m->rules.alert_ns),
	              timeout = fw_time_add_ns(m->last, m->rules.timeout_ns);
	if (m->trend > 0 && fw_time_compare(alert, now) < 0 && fw_time_compare(alert, timeout) <= 0) {
		change(m, alert, m->seen, m->seen_cause, transition);
		return true;
	}
	if (m->state != FW_NO_POSITION && fw_time_compare(timeout, now) < 0) {
		change(m, timeout, FW_NO_POSITION, FW_CAUSE_TIMEOUT, transition);
		return true;
	}
	return false;
}

/* Which way the epochs go, since when, and how bad the worst of them was. */
static void follow(fw_integrity *m, fw_time time)
{
	const int trend = (m->seen > m->state) - (m->seen < m->state);
	if (trend != m->trend) {
		m->trend = trend;
		m->since = time;
		m->worst = FW_RELIABLE;
	}
	if (m->seen >= m->worst) {
		m->worst = m->seen;
		m->worst_cause = m->seen_cause;
	}
}

fw_status fw_integrity_update(fw_integrity *m, fw_time time, const fw_integrity_epoch *epoch,
                              fw_transition *transition)
{
	if (fw_time_compare(time, m->last) <= 0 || fw_time_compare(time, m->changed) < 0)
		return FW_EINVAL;
	m->seen = judge(m, epoch, &m->seen_cause);
	follow(m, time);

	const bool better = m->trend < 0;
	const int64_t wait_ns = !m->begun || m->seen == FW_NO_POSITION ? 0
	                        : better                               ? m->rules.hold_ns
	                                                               : m->rules.alert_ns;
	m->begun = true;
	m->last = time;
	*transition = (fw_transition){time, m->state, m->state, m->seen_cause};
	if (m->trend != 0 && fw_time_diff_ns(time, m->since) >= wait_ns)
		change(m, time, better ? m->worst : m->seen, better ? m->worst_cause : m->seen_cause,
		       transition);
	return FW_OK;
}

void fw_integrity_restart(fw_integrity *m)
{
	m->begun = false;
	m->trend = 0;
	m->last = m->changed = (fw_time){INT64_MIN};
}
