# The build machine's own compiler.
set(SWIFTLET_BOARD linux-x86_64)
