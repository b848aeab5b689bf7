# The libraries that cvol uses. scripts/dependencies.sh installs them.
find_package(PkgConfig REQUIRED)
find_package(OpenMP COMPONENTS C)
find_package(Threads REQUIRED)
find_package(ZLIB REQUIRED)
find_package(PNG REQUIRED)
find_package(GIF 5.2 REQUIRED)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(JANSSON REQUIRED IMPORTED_TARGET jansson)
# FFTW is GPL: it is used only on request, and for comparison in bench/algebra.py.
if(CVOL_FFT STREQUAL "fftw" OR CVOL_BENCH)
  pkg_check_modules(FFTW REQUIRED IMPORTED_TARGET fftw3f)
endif()

# Optional: WebP, also animated.
pkg_check_modules(WEBP IMPORTED_TARGET libwebpmux libwebp)

# Optional: the viewer; JPEG.
pkg_check_modules(MICROHTTPD IMPORTED_TARGET libmicrohttpd>=0.9.71)
pkg_check_modules(TURBOJPEG IMPORTED_TARGET libturbojpeg)

# Optional: readers of volume formats.
pkg_check_modules(TIFF IMPORTED_TARGET libtiff-4>=4.5)
pkg_check_modules(HDF5 IMPORTED_TARGET hdf5)

# Optional: pictures by several processes. (The sanitizers would report leaks of MPI libraries.)
if(NOT CVOL_SANITIZE)
  find_package(MPI COMPONENTS C)
endif()

# GDCM is C++; cvol uses only its codecs. (GDCM's own CMake package needs programs that Debian's development package
# does not contain.)
file(GLOB gdcm_folders /usr/include/gdcm-3* /usr/local/include/gdcm-3*)
find_path(GDCM_INCLUDE_DIR gdcmImageCodec.h HINTS ${gdcm_folders} PATH_SUFFIXES gdcm-3.0)
find_library(GDCM_MSFF_LIBRARY gdcmMSFF)
find_library(GDCM_DSED_LIBRARY gdcmDSED)
find_library(GDCM_COMMON_LIBRARY gdcmCommon)
include(CheckLanguage)
check_language(CXX)
if(GDCM_INCLUDE_DIR AND GDCM_MSFF_LIBRARY AND GDCM_DSED_LIBRARY AND GDCM_COMMON_LIBRARY AND CMAKE_CXX_COMPILER)
  enable_language(CXX)
  set(CMAKE_CXX_STANDARD 11)
  set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")
  set(GDCM_FOUND ON)
endif()

# Print the features that this build lacks.
set(missing "")
foreach(part "OpenMP_C:threads (OpenMP)" "TIFF:reading TIFF (libtiff)" "HDF5:HDF5 (libhdf5)"
    "GDCM:compressed DICOM (GDCM)" "WEBP:WebP films (libwebp)" "MICROHTTPD:the viewer (libmicrohttpd)"
    "TURBOJPEG:the viewer (libturbojpeg)")
  string(REPLACE ":" ";" part "${part}")
  list(GET part 0 name)
  list(GET part 1 feature)
  if(NOT ${name}_FOUND)
    list(APPEND missing "${feature}")
  endif()
endforeach()
if(missing)
  list(JOIN missing ", " missing)
  message(STATUS "This build of cvol lacks ${missing}")
endif()
