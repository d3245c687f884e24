# Column numbers of a record type, from its definition: awk -f columns.awk NAME.lcm > furrow_NAME_columns.h
# Column 0 is the member after `present`.
/^struct/ { type = $2; printf "/* Generated from %s.lcm. */\nenum {\n", type }
/^\t[a-z]/ {
	split($0, statement, ";")
	n = split(statement[1], word, " ")
	if (word[n] != "present") printf "\tFW_COL_%s_%s = %d,\n", type, word[n], column++
}
END { printf "\tFW_COL_%s_COUNT = %d\n};\n", type, column }
