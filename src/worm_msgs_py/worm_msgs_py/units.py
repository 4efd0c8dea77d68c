"""Units, once for all packages: inside SI and nanoseconds, for people mm."""

NS_PER_S = 1_000_000_000
MM_PER_M = 1e3
UM_PER_MM = 1e3
