/* Pairs of files of Analyze and NIfTI: NAME.hdr and NAME.img. */
#ifndef CVOL_VOLUME_FORMATS_ANALYZE_H
#define CVOL_VOLUME_FORMATS_ANALYZE_H

/* 1 if the name ends in .img or .img.gz, and a file of the same name with .hdr or .hdr.gz
 * begins as headers of Analyze and NIfTI do. */
int cvol_analyze_has_header(const char *path);

/* The header of NAME.img or NAME.img.gz, which may be packed if the image is. NULL: the name does
 * not end so, or no memory. The caller frees it. */
char *cvol_analyze_header_of(const char *path);

#endif
