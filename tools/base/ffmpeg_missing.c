/* A system on which cvol starts no other programs (CMakeLists.txt). */
#include <stdio.h>

#include "tools/base/ffmpeg.h"

int has_ffmpeg(void)
{
    return 0;
}

ffmpeg *open_ffmpeg(const char *path, int width, int height, const cvol_film_options *options,
                    char *message, size_t message_bytes)
{
    (void)width, (void)height, (void)options;
    snprintf(message, message_bytes,
             "%s: this format needs ffmpeg, which cvol does not use on this system; write numbered "
             "pictures (-o 'turn-{n}.png')",
             path);
    return NULL;
}

int add_to_ffmpeg(ffmpeg *f, const cvol_image *image, char *message, size_t message_bytes)
{
    (void)f, (void)image, (void)message, (void)message_bytes;
    return -1; /* none was opened */
}

int commit_ffmpeg(ffmpeg *f, char *message, size_t message_bytes)
{
    (void)f, (void)message, (void)message_bytes;
    return -1;
}

void abandon_ffmpeg(ffmpeg *f)
{
    (void)f;
}
