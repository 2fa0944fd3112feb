#!/bin/sh
# expect_exit.sh STATUS COMMAND...: succeeds when the command ends with that status.
expected=$1
shift
"$@" </dev/null
actual=$?
echo "exit status $actual, expected $expected"
test "$actual" -eq "$expected"
