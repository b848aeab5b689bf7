/* What the wheel's libcvol.so has in place of parts of other libraries (bundle.py). libtiff and
 * blosc refer to libraries that the wheel leaves out: libjbig, which is GPL, and those in C++. The
 * linker takes these functions and leaves the members of the archives that need the libraries. */
#include <math.h>
#include <stdio.h>
#include <tiffio.h>

#define HIDDEN __attribute__((visibility("hidden")))

/* Debian compiles static libraries for programs: their code takes the address of a variable from
 * the place of the code itself. For the streams of libc no shared library can do that, so bundle.py
 * gives them these names. */
HIDDEN FILE *cvol_wheel_stdin, *cvol_wheel_stdout, *cvol_wheel_stderr;
__attribute__((constructor)) static void copy_streams(void)
{
    cvol_wheel_stdin = stdin;
    cvol_wheel_stdout = stdout;
    cvol_wheel_stderr = stderr;
}

/* libtiff calls these when a file names the compression. */
HIDDEN int TIFFInitJBIG(TIFF *tiff, int scheme);
int TIFFInitJBIG(TIFF *tiff, int scheme)
{
    TIFFErrorExtR(tiff, "TIFF", "compression %d (JBIG) is not in this build of cvol", scheme);
    return 0;
}
HIDDEN int TIFFInitLERC(TIFF *tiff, int scheme);
int TIFFInitLERC(TIFF *tiff, int scheme)
{
    TIFFErrorExtR(tiff, "TIFF", "compression %d (LERC) is not in this build of cvol", scheme);
    return 0;
}

/* The interface of Snappy for blosc; 1 is SNAPPY_INVALID_INPUT. */
HIDDEN int snappy_compress(const char *in, size_t size, char *out, size_t *out_size);
int snappy_compress(const char *in, size_t size, char *out, size_t *out_size)
{
    (void)in, (void)size, (void)out, (void)out_size;
    return 1;
}
HIDDEN int snappy_uncompress(const char *in, size_t size, char *out, size_t *out_size);
int snappy_uncompress(const char *in, size_t size, char *out, size_t *out_size)
{
    (void)in, (void)size, (void)out, (void)out_size;
    return 1;
}
HIDDEN size_t snappy_max_compressed_length(size_t size);
size_t snappy_max_compressed_length(size_t size)
{
    return size;
}

/* glibc 2.35 gave hypot a new version, which differs only in errno. The old one serves glibc 2.34
 * too. */
__asm__(".symver cvol_wheel_hypot, hypot@GLIBC_2.2.5");
double cvol_wheel_hypot(double x, double y);
HIDDEN double __wrap_hypot(double x, double y);
double __wrap_hypot(double x, double y)
{
    return cvol_wheel_hypot(x, y);
}
