# A log cut at a thousand places.
exec bash "$SRC/tests/cli/cuts.sh" 1000
