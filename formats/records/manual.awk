# The record types for the manual: awk -f manual.awk obs.lcm epoch.lcm ... (mdoc)
function flush_row() { if (type != "") print ".El" }
FNR == 1 { description = "" }
/^\/\/ / { description = substr($0, 4) }
/^struct/ {
	flush_row()
	type = $2
	printf ".Ss %s\n%s\n.Bl -tag -width Ds -compact\n", type, description
}
/^\t[a-z]/ {
	split($0, part, "; // ")
	n = split(part[1], word, " ")
	name = word[n]
	if (name != "present" && name != "gps_week" && name != "tow_s")
		printf ".It Cm %s\n%s\n", name, part[2]
}
END { flush_row() }
