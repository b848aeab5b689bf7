/* Animations through ffmpeg, if it is installed: a child process reads raw RGB from a pipe and
 * writes a hidden file in the folder of the output, which gets its name after success. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tools/base/cli.h"
#include "tools/base/ffmpeg.h"

#define LINE_MAX_BYTES 300 /* bytes of a message of ffmpeg */
/* ffmpeg hangs if it accepts no data for HANG_MS. */
enum { LOOK_MS = 200, HANG_MS = 60000 };

struct ffmpeg {
    pid_t child;
    int to, from; /* pipes: pictures; error messages */
    int width, height;
    char *path, *hidden;
    uint8_t *row;
    int vp9;
    char size[32], rate[32], crf[16];
};

static void free_ffmpeg(ffmpeg *f)
{
    if (f->to >= 0)
        close(f->to);
    if (f->from >= 0)
        close(f->from);
    free(f->path);
    free(f->hidden);
    free(f->row);
    free(f);
}

/* FOLDER/.NAME.PID.mp4: ffmpeg takes the format from the extension. */
static char *hidden_name(const char *path)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const char *ending = strrchr(name, '.');
    char *hidden = NULL;
    if (asprintf(&hidden, "%.*s.%s.%ld%s", (int)(name - path), path, name, (long)getpid(), ending) <
        0)
        return NULL;
    return hidden;
}

/* Prepares the arguments before the fork: the child may call only few functions. */
static void describe(ffmpeg *f, const cvol_film_options *options)
{
    const char *ending = strrchr(f->path, '.');
    f->vp9 = ending && !strcasecmp(ending, ".webm");
    snprintf(f->size, sizeof f->size, "%dx%d", f->width, f->height);
    snprintf(f->rate, sizeof f->rate, "%.6g", options->frames_per_second);
    /* quality 90: CRF 18 (x264) and 27 (VP9), common choices for high quality */
    snprintf(f->crf, sizeof f->crf, "%d",
             f->vp9 ? 63 - options->quality * 2 / 5 : 51 - options->quality * 11 / 30);
}

/* Pictures of odd size get one more row or column: colour has half the resolution. */
static void run(ffmpeg *f)
{
    char *const arguments[] = {"ffmpeg",   "-loglevel",
                               "error",    "-nostdin",
                               "-y",       "-f",
                               "rawvideo", "-pix_fmt",
                               "rgb24",    "-s",
                               f->size,    "-r",
                               f->rate,    "-i",
                               "-",        "-an",
                               "-vf",      "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                               "-pix_fmt", "yuv420p",
                               "-c:v",     f->vp9 ? "libvpx-vp9" : "libx264",
                               "-crf",     f->crf,
                               "-b:v",     "0",
                               f->hidden,  NULL};
    execvp("ffmpeg", arguments);
}

/* In the child, in its own process group: Ctrl-C reaches only the parent. */
static void execute_ffmpeg(ffmpeg *f, int in, int out, int failed)
{
    const int nothing = open("/dev/null", O_WRONLY | O_CLOEXEC);
    setpgid(0, 0);
    signal(SIGPIPE, SIG_DFL);
    if (nothing >= 0 && dup2(in, STDIN_FILENO) >= 0 && dup2(nothing, STDOUT_FILENO) >= 0 &&
        dup2(out, STDERR_FILENO) >= 0)
        run(f);
    const int reason = errno;
    if (write(failed, &reason, sizeof reason) < 0)
        _exit(126);
    _exit(127);
}

/* 0, or the errno of the failed start. */
static int start(ffmpeg *f)
{
    int in[2] = {-1, -1}, out[2] = {-1, -1}, failed[2] = {-1, -1}, reason = 0;
    if (pipe2(in, O_CLOEXEC) || pipe2(out, O_CLOEXEC) || pipe2(failed, O_CLOEXEC) ||
        (f->child = fork()) < 0)
        reason = errno;
    else if (f->child == 0)
        execute_ffmpeg(f, in[0], out[1], failed[1]);
    const int unused[4] = {in[0], out[1], failed[1], -1};
    for (int i = 0; i < 3; i++)
        if (unused[i] >= 0)
            close(unused[i]);
    f->to = in[1];
    if (f->to >= 0)
        fcntl(f->to, F_SETFL, O_NONBLOCK);
    f->from = out[0];
    if (!reason && read(failed[0], &reason, sizeof reason) != sizeof reason)
        reason = 0; /* closed by a successful exec */
    if (failed[0] >= 0)
        close(failed[0]);
    if (reason && f->child > 0)
        waitpid(f->child, NULL, 0);
    return reason;
}

int has_ffmpeg(void)
{
    const char *folder = getenv("PATH");
    char path[4096];
    while (folder && *folder) {
        const size_t length = strcspn(folder, ":");
        const int size = snprintf(path, sizeof path, "%.*s/ffmpeg", (int)length, folder);
        if (size < (int)sizeof path && !access(path, X_OK))
            return 1;
        folder += length + (folder[length] == ':');
    }
    return 0;
}

ffmpeg *open_ffmpeg(const char *path, int width, int height, const cvol_film_options *options,
                    char *message, size_t message_bytes)
{
    ffmpeg *f = calloc(1, sizeof *f);
    if (f) {
        *f = (ffmpeg){.to = -1, .from = -1, .width = width, .height = height};
        f->path = strdup(path);
        f->hidden = hidden_name(path);
        f->row = malloc(3 * (size_t)width);
    }
    if (!f || !f->path || !f->hidden || !f->row) {
        snprintf(message, message_bytes, "not enough memory");
        if (f)
            free_ffmpeg(f);
        return NULL;
    }
    describe(f, options);
    const int reason = start(f);
    if (!reason)
        return f;
    if (reason == ENOENT)
        snprintf(message, message_bytes,
                 "%s: this format needs ffmpeg, which is not installed; write .gif%s or numbered "
                 "pictures (-o 'turn-{n}.png')",
                 path, strstr(cvol_film_formats(), ".webp") ? ", .webp" : "");
    else
        snprintf(message, message_bytes, "%s: cannot start ffmpeg: %s", path, strerror(reason));
    free_ffmpeg(f);
    return NULL;
}

/* Waits until the pipe is ready or closed. 0: after an interrupt or most_ms. */
static int wait_for(int fd, short what, int most_ms)
{
    for (int left = most_ms; left > 0 && !was_interrupted(); left -= LOOK_MS) {
        struct pollfd p = {.fd = fd, .events = what};
        const int ready = poll(&p, 1, LOOK_MS);
        if (ready > 0 || (ready < 0 && errno != EINTR))
            return 1;
    }
    return 0;
}

/* Kills ffmpeg and its children. */
static void kill_ffmpeg(const ffmpeg *f)
{
    kill(-f->child, SIGKILL);
}

/* Waits for the end; 0 after success. `last_line`: the last line of ffmpeg's messages. */
static int finish(ffmpeg *f, char last_line[LINE_MAX_BYTES])
{
    char text[4096];
    size_t size = 0;
    int result = 0;
    close(f->to);
    f->to = -1;
    for (;;) {
        if (size == sizeof text - 1) { /* keep the later half */
            memmove(text, text + size / 2, size - size / 2);
            size -= size / 2;
        }
        if (!wait_for(f->from, POLLIN, INT_MAX))
            kill_ffmpeg(f);
        const ssize_t got = read(f->from, text + size, sizeof text - 1 - size);
        if (got == 0 || (got < 0 && errno != EINTR))
            break;
        size += got > 0 ? (size_t)got : 0;
    }
    while (waitpid(f->child, &result, 0) < 0 && errno == EINTR)
        ;
    while (size && (text[size - 1] == '\n' || text[size - 1] == '\r'))
        size--;
    text[size] = '\0';
    const char *line = strrchr(text, '\n');
    snprintf(last_line, LINE_MAX_BYTES, "%.*s", LINE_MAX_BYTES - 1,
             size ? (line ? line + 1 : text) : "it printed no message");
    return !WIFEXITED(result) || WEXITSTATUS(result) != 0;
}

/* Reports a failure of ffmpeg. */
static int report_failure(ffmpeg *f, const char line[LINE_MAX_BYTES], char *message,
                          size_t message_bytes)
{
    snprintf(message, message_bytes, "%s: ffmpeg failed: %s", f->path, line);
    return -1;
}

/* 1: all bytes written; 0: the pipe is closed; -1: ffmpeg hangs, or an interrupt. */
static int write_all(int to, const uint8_t *data, size_t size)
{
    while (size) {
        const ssize_t written = write(to, data, size);
        if (written < 0 && errno == EAGAIN && !wait_for(to, POLLOUT, HANG_MS))
            return -1;
        if (written < 0 && (errno == EINTR || errno == EAGAIN))
            continue;
        if (written <= 0)
            return 0;
        data += written;
        size -= (size_t)written;
    }
    return 1;
}

int add_to_ffmpeg(ffmpeg *f, const cvol_image *image, char *message, size_t message_bytes)
{
    const size_t width = (size_t)f->width;
    for (int y = 0; y < f->height; y++) {
        const uint8_t *rgba = image->rgba + 4 * width * (size_t)y;
        for (size_t x = 0; x < width; x++)
            memcpy(f->row + 3 * x, rgba + 4 * x, 3);
        const int written = write_all(f->to, f->row, 3 * width);
        if (written < 0) {
            snprintf(message, message_bytes, "%s: %s", f->path,
                     was_interrupted() ? "interrupted" : "ffmpeg accepts no more pictures");
            return -1;
        }
        if (!written) {
            char line[LINE_MAX_BYTES];
            finish(f, line);
            return report_failure(f, line, message, message_bytes);
        }
    }
    return 0;
}

int commit_ffmpeg(ffmpeg *f, char *message, size_t message_bytes)
{
    char line[LINE_MAX_BYTES];
    int failed = 0;
    if (finish(f, line)) {
        failed = report_failure(f, line, message, message_bytes);
    } else if (rename(f->hidden, f->path)) {
        snprintf(message, message_bytes, "%s: cannot write: %s", f->path, strerror(errno));
        failed = -1;
    }
    if (failed)
        unlink(f->hidden);
    free_ffmpeg(f);
    return failed;
}

void abandon_ffmpeg(ffmpeg *f)
{
    if (f->to >= 0) { /* it still runs */
        kill_ffmpeg(f);
        waitpid(f->child, NULL, 0);
    }
    unlink(f->hidden);
    free_ffmpeg(f);
}
