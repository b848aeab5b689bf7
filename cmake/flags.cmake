# Warnings, sanitizers, and the compiler flags of each kind of code.
include(CheckCSourceCompiles)
add_library(cvol_flags INTERFACE)
target_compile_options(cvol_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wmissing-prototypes -Wvla
  -Wno-psabi -fvisibility=hidden -ffp-contract=off
  # Without optimization GCC's intrinsics are macros, whose conversions it reports.
  $<$<AND:$<COMPILE_LANG_AND_ID:C,GNU>,$<CONFIG:Debug>>:-Wno-sign-conversion>
  $<$<COMPILE_LANG_AND_ID:C,Clang>:-Wno-pass-failed>) # warns of loops that it does not vectorize
# Every operation on floats rounds to a float: GCC for s390x would compute with doubles in C11 (FLT_EVAL_METHOD 1), and
# for 32-bit x86 with the 80 bits of x87.
check_c_source_compiles("#ifndef __i386__
#error
#endif
int main(void) { return 0; }" CVOL_X86_32) # CMAKE_SYSTEM_PROCESSOR does not say with -m32
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^s390" AND CMAKE_C_COMPILER_ID STREQUAL "GNU")
  target_compile_options(cvol_flags INTERFACE -fexcess-precision=fast)
elseif(CVOL_X86_32)
  target_compile_options(cvol_flags INTERFACE -msse2 -mfpmath=sse)
endif()
if(CMAKE_SIZEOF_VOID_P EQUAL 4 AND NOT WIN32)
  target_compile_definitions(cvol_flags INTERFACE _FILE_OFFSET_BITS=64) # files of more than 2 GiB
endif()
if(WIN32)
  # src/windows has what MinGW-w64 lacks of POSIX. printf is its own, of C11, which the compiler's check of formats does
  # not know, and parameters may have names of POSIX functions; builds for other systems check both.
  target_compile_options(cvol_flags INTERFACE "SHELL:-include ${PROJECT_SOURCE_DIR}/src/windows/posix.h" -std=gnu11
    -Wno-format -Wno-shadow)
  target_compile_definitions(cvol_flags INTERFACE __USE_MINGW_ANSI_STDIO=1 _FILE_OFFSET_BITS=64)
  target_include_directories(cvol_flags SYSTEM INTERFACE ${PROJECT_SOURCE_DIR}/src/windows/include)
  target_link_options(cvol_flags INTERFACE -static) # the compiler's libraries are on no other machine
endif()
if(NOT OpenMP_C_FOUND)
  # Ignored pragmas leave the variables that only they use.
  target_compile_options(cvol_flags INTERFACE -Wno-unknown-pragmas -Wno-unused-parameter -Wno-unused-variable)
endif()
if(CVOL_WERROR)
  target_compile_options(cvol_flags INTERFACE -Werror)
endif()
if(CVOL_SANITIZE STREQUAL thread)
  set(CVOL_SANITIZERS -fsanitize=thread)
  set(CVOL_SANITIZERS_OF_MODULES -fsanitize=thread)
  target_compile_options(cvol_flags INTERFACE ${CVOL_SANITIZERS} -g1)
  target_link_options(cvol_flags INTERFACE ${CVOL_SANITIZERS})
elseif(CVOL_SANITIZE)
  set(CVOL_SANITIZERS -fsanitize=address,undefined)
  set(CVOL_SANITIZERS_OF_MODULES -fsanitize=address)
  target_compile_options(cvol_flags INTERFACE
    ${CVOL_SANITIZERS} -fno-sanitize-recover=all -fno-omit-frame-pointer -g1
    # These checks take more than half of the compile time of kernels; the address sanitizer finds their relevant
    # errors too.
    $<$<BOOL:$<TARGET_PROPERTY:CVOL_KERNELS>>:-fno-sanitize=null,object-size,pointer-overflow>)
  target_link_options(cvol_flags INTERFACE ${CVOL_SANITIZERS})
endif()

# The instruction sets of the kernels. "machine" leaves out what this machine does not need: it compiles the base set,
# and the widest set that the machine has. "tested" is for tests on this machine only: all sets, but AVX-512 is not
# optimized if the machine does not have it.
set(CVOL_SETS_OF_KERNELS base)
if(WIN32)
  # GCC aligns the stack of 64-bit Windows to 16 bytes only, and stores vectors of 32 and 64 bytes there as if it were
  # aligned to those (its bug 54412). The other sets would crash; not always, and hardly under Wine.
  target_compile_definitions(cvol_flags INTERFACE CVOL_BASE_SET_ONLY)
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64|amd64" AND NOT CVOL_X86_32)
  list(APPEND CVOL_SETS_OF_KERNELS avx2 avx512)
  set(CVOL_HAS_AVX512 unknown)
  if(EXISTS /proc/cpuinfo)
    file(STRINGS /proc/cpuinfo CVOL_HAS_AVX512 REGEX "avx512vl" LIMIT_COUNT 1)
  endif()
  if(CVOL_SETS STREQUAL machine AND NOT CVOL_HAS_AVX512 STREQUAL unknown)
    if(CVOL_HAS_AVX512)
      list(REMOVE_ITEM CVOL_SETS_OF_KERNELS avx2)
      target_compile_definitions(cvol_flags INTERFACE CVOL_WITHOUT_AVX2)
    else()
      list(REMOVE_ITEM CVOL_SETS_OF_KERNELS avx512)
      target_compile_definitions(cvol_flags INTERFACE CVOL_WITHOUT_AVX512)
    endif()
  endif()
endif()

# cvol_add_simd_sources(TARGET FILES...): compiles kernel files once per instruction set. CVOL_SIMD(name) gives each
# function the suffix of its set. src/base/cpu.h selects the set at run time.
function(cvol_add_simd_sources target)
  set(flags_base "")
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64|amd64" AND CMAKE_BUILD_TYPE STREQUAL Release)
    # Processors without AVX2 are older than 2013: their set is worth two thirds of the compile time of -O3.
    set(flags_base -O2)
  endif()
  set(flags_avx2 -mavx2 -mfma -mf16c -mtune=haswell)
  set(flags_avx512 -mavx512f -mavx512bw -mavx512dq -mavx512vl -mfma -mf16c
      -mprefer-vector-width=512)
  if(CVOL_SETS STREQUAL tested AND NOT CVOL_HAS_AVX512 AND CMAKE_C_COMPILER_ID STREQUAL "GNU")
    # Half of the compile time; no test can run it here. GCC gives false warnings then.
    list(APPEND flags_avx512 -O1 -Wno-maybe-uninitialized)
  endif()
  if(CVOL_SANITIZE)
    # The neural coder takes a third of the time of the sanitized tests that use it; it compiles in 3 s.
    set(neural ${ARGN})
    list(FILTER neural INCLUDE REGEX "neural_simd.c$")
    set_source_files_properties(${neural} PROPERTIES COMPILE_OPTIONS -O3)
  endif()
  foreach(set IN LISTS CVOL_SETS_OF_KERNELS)
    set(object ${target}_${set})
    add_library(${object} OBJECT ${ARGN})
    target_link_libraries(${object} PRIVATE cvol_flags)
    target_include_directories(${object} PRIVATE
      ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src)
    target_compile_options(${object} PRIVATE ${flags_${set}})
    set_target_properties(${object} PROPERTIES CVOL_KERNELS ON)
    if(CVOL_SANITIZE AND set STREQUAL "base" AND CMAKE_C_COMPILER_ID STREQUAL "GNU")
      # The address sanitizer calls a function instead of inlining each check: half of the compile time. Not with
      # AVX-512: around such calls GCC 12 spills 8 bits of a mask and reads 64 back
      # (codec/quantize/true_length_simd.c).
      target_compile_options(${object} PRIVATE "SHELL:--param asan-instrumentation-with-call-threshold=0")
    endif()
    target_compile_definitions(${object} PRIVATE CVOL_SIMD_SET=${set})
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:${object}>)
  endforeach()
endfunction()
