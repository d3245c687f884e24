# The record types in furrow-stream(5) are those of the definitions.
exec "$SRC/scripts/manual.sh" check
