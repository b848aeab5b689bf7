/* Mappings of whole files for reading (windows/machine.c). */
#ifndef CVOL_WINDOWS_MMAN_H
#define CVOL_WINDOWS_MMAN_H

#define PROT_NONE 0
#define PROT_READ 1
#define MAP_PRIVATE 2
#define MAP_ANONYMOUS 32
#define MAP_FAILED ((void *)-1)

#define mmap cvol_posix_mmap
#define munmap cvol_posix_munmap
/* Fails for anything but PROT_READ of a file. */
void *cvol_posix_mmap(void *at, size_t size, int protection, int flags, int fd, off_t offset);
int cvol_posix_munmap(void *memory, size_t size);

#endif
