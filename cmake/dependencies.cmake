# The libraries that cvol stands on. scripts/dependencies.sh installs them.
find_package(PkgConfig REQUIRED)
find_package(OpenMP COMPONENTS C)
find_package(Threads REQUIRED)
find_package(ZLIB REQUIRED)
find_package(PNG REQUIRED)
find_package(GIF 5.2 REQUIRED)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(JANSSON REQUIRED IMPORTED_TARGET jansson)
pkg_check_modules(FFTW REQUIRED IMPORTED_TARGET fftw3f)

# Animated WebP, where it is.
pkg_check_modules(WEBP IMPORTED_TARGET libwebpmux libwebp)

# Formats of volumes that other libraries read, where these are.
pkg_check_modules(TIFF IMPORTED_TARGET libtiff-4>=4.5)

find_path(NIFTI_INCLUDE_DIR nifti2_io.h PATH_SUFFIXES nifti REQUIRED)
find_library(NIFTI2_LIBRARY nifti2 REQUIRED)
find_library(ZNZ_LIBRARY znz REQUIRED)
add_library(cvol_nifti INTERFACE)
target_include_directories(cvol_nifti SYSTEM INTERFACE ${NIFTI_INCLUDE_DIR})
target_link_libraries(cvol_nifti INTERFACE ${NIFTI2_LIBRARY} ${ZNZ_LIBRARY})
