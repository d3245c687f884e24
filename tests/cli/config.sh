# -c, --set and --print-config: one table of keys, and what is said last counts.
. "$SRC/tests/cli/case.bash"

cat > good.ini <<'EOF'
; keys before any section are every tool's
every = 20
every = 10 ; the later one counts
[pl-monitor]
hal = 40
[sbf2csv]
types = pvt,dop   ; two
stream = yes
antenna = aux1
EOF
gives 0 -c good.ini --print-config
silent
cat > wanted <<'EOF'
[sbf2csv]
types = pvt,dop
stream = yes
format = csv
list = no
every = 10
antenna = aux1
nav = both
quiet = no
verbose = no
progress = auto
EOF
same wanted out

# What is printed can be read again.
cp out again.ini
gives 0 -c again.ini --print-config
same wanted out

# Options win over the file, wherever they stand; --set is an option.
gives 0 --antenna main -c good.ini --set every=5 --set antenna=aux2 --print-config
prints "antenna = aux2"
prints "every = 5"
gives 0 -c good.ini --set stream=no -t dop "$log"
rows 6
gives 0 -q -c good.ini "$log"
prints "#cfg every=10"
prints "#cfg antenna=aux1"
prints "#pvt,gps_week,tow_s,"

printf '[sbf2csv]\nevery = 10\nantena = main\n' > key.ini
gives 2 -c key.ini "$log"
says "key.ini: unknown option or key 'antena'; did you mean 'antenna'?"
says "key.ini:3: setting refused"
no_output
printf '[sbf2csv]\nevery = often\n' > value.ini
gives 2 -c value.ini "$log"
says "value.ini: every: 'often' is not a number from 0.001 to 604800"
printf '[sbf2csv]\nevery\n' > syntax.ini
gives 2 -c syntax.ini "$log"
says "syntax.ini:2: not a section, key = value, or comment"
gives 3 -c missing.ini "$log"
says "missing.ini: No such file or directory"
gives 3 -c . "$log"
no_output
finish
