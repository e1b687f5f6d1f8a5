# Toolchain: the firmware for arm64 with Debian's cross compiler and Debian's libraries unpacked in
# STROBE_SYSROOT (tests/kernel/prepare). Headers without code of a machine's own are this machine's.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES STROBE_SYSROOT)

set(ENV{PKG_CONFIG_LIBDIR} ${STROBE_SYSROOT}/usr/lib/aarch64-linux-gnu/pkgconfig)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${STROBE_SYSROOT})
# Libraries of libraries, as their owners find them when they run.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-Wl,-rpath-link,${STROBE_SYSROOT}/usr/lib/aarch64-linux-gnu")
