set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR cortex-m7)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_AR arm-none-eabi-gcc-ar)
set(CMAKE_RANLIB arm-none-eabi-gcc-ranlib)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)

set(CMAKE_CXX_FLAGS_INIT
    "-mthumb -mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard -ffunction-sections -fdata-sections -fno-exceptions \
-fno-rtti -fno-unwind-tables -fno-asynchronous-unwind-tables -fno-threadsafe-statics -fno-use-cxa-atexit")
# No start files, no libstdc++, no libnosys: nothing that could bring a heap.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-nostdlib -Wl,--gc-sections -Wl,--fatal-warnings")
set(CMAKE_CXX_STANDARD_LIBRARIES "-Wl,--start-group -lgcc -lc_nano -lm -Wl,--end-group")

set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE BOTH)  # Eigen is headers only: the build machine's copy serves
# One guest instruction is one nanosecond. Standard input must be /dev/null, as ctest has it.
set(CMAKE_CROSSCOMPILING_EMULATOR
    qemu-system-arm -M mps2-an500 -display none -monitor none -serial stdio -icount shift=0
    -semihosting-config enable=on,target=native -kernel)

set(SWIFTLET_BOARD mps2-an500)
