/* Animations that are made in the background: their list, and its requests. Their files are in a
 * temporary folder, which the viewer removes at its end. */
#define _XOPEN_SOURCE 700
#include "viewer/films/films.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "viewer/base/priority.h"
#include "viewer/films/film_make.h"

/* Pixels of an animation: an hour of small pictures, or three minutes of large ones. */
#define FILM_PIXELS_MAX 1e10

typedef enum film_state { FILM_RUNNING, FILM_DONE, FILM_FAILED } film_state;

typedef struct film {
    char id[16];
    films *all;
    char *path;
    film_settings settings;
    int holders, removed; /* protected by the lock, like the fields below */
    film_state state;
    double fraction;
    uint64_t bytes;
    char message[FILM_MESSAGE_BYTES];
} film;

struct films {
    const viewer_options *options;
    int threads;
    pthread_mutex_t lock;
    pthread_cond_t ended; /* signalled when a maker ends or must stop */
    char *folder;         /* NULL: not made yet */
    film *list[FILMS_MAX];
    int count, next_id, makers, drawing, closing; /* drawing: 1 while one is drawn */
};

/* ---- making -----------------------------------------------------------------------------------
 */

static void release(film *f)
{
    films *all = f->all;
    pthread_mutex_lock(&all->lock);
    const int last = --f->holders == 0;
    pthread_mutex_unlock(&all->lock);
    if (!last)
        return;
    if (f->path)
        unlink(f->path);
    free(f->path);
    view_free(&f->settings.view);
    free(f);
}

static int is_cancelled(void *user, const char *what, double fraction)
{
    film *f = user;
    (void)what;
    (void)fraction;
    pthread_mutex_lock(&f->all->lock);
    const int cancelled = f->removed || f->all->closing;
    pthread_mutex_unlock(&f->all->lock);
    return cancelled;
}

static void set_fraction(void *user, double fraction)
{
    film *f = user;
    pthread_mutex_lock(&f->all->lock);
    f->fraction = fraction;
    pthread_mutex_unlock(&f->all->lock);
}

/* Waits until no other animation is drawn; 0: this one was removed. */
static int take_turn(film *f)
{
    films *all = f->all;
    pthread_mutex_lock(&all->lock);
    while (all->drawing && !f->removed && !all->closing)
        pthread_cond_wait(&all->ended, &all->lock);
    const int wanted = !f->removed && !all->closing;
    if (wanted)
        all->drawing = 1;
    pthread_mutex_unlock(&all->lock);
    return wanted;
}

static void *make(void *argument)
{
    film *f = argument;
    films *all = f->all;
    char message[FILM_MESSAGE_BYTES] = "not enough memory for an animation";
    struct stat file = {0};
    lower_thread_priority();
    const int turn = take_turn(f);
    cvol_context *context = turn ? cvol_context_create() : NULL;
    int code = -1;
    if (context) {
        cvol_context_set_threads(context, all->threads > 1 ? all->threads / 2 : 1);
        cvol_context_set_progress(context, is_cancelled, f);
        code = film_make(context, &f->settings, all->options->movies, f->path, set_fraction, f,
                         message);
    }
    cvol_context_free(context);
    if (!code && stat(f->path, &file)) {
        snprintf(message, sizeof message, "the file of the animation is missing: %s",
                 strerror(errno));
        code = -1;
    }
    pthread_mutex_lock(&all->lock);
    f->state = code ? FILM_FAILED : FILM_DONE;
    f->bytes = (uint64_t)file.st_size;
    snprintf(f->message, sizeof f->message, "%s", code ? message : "");
    pthread_mutex_unlock(&all->lock);
    release(f);
    pthread_mutex_lock(&all->lock);
    all->makers--;
    all->drawing -= turn;
    pthread_cond_broadcast(&all->ended);
    pthread_mutex_unlock(&all->lock);
    return NULL;
}

/* ---- the list ---------------------------------------------------------------------------------
 */

films *films_open(const viewer_options *options, int threads)
{
    films *all = calloc(1, sizeof *all);
    if (!all)
        return NULL;
    all->options = options;
    all->threads = threads;
    all->next_id = 1;
    pthread_mutex_init(&all->lock, NULL);
    pthread_cond_init(&all->ended, NULL);
    return all;
}

void films_close(films *all)
{
    if (!all)
        return;
    pthread_mutex_lock(&all->lock);
    all->closing = 1;
    pthread_cond_broadcast(&all->ended);
    while (all->makers)
        pthread_cond_wait(&all->ended, &all->lock);
    pthread_mutex_unlock(&all->lock);
    while (all->count)
        release(all->list[--all->count]);
    if (all->folder)
        rmdir(all->folder);
    free(all->folder);
    pthread_cond_destroy(&all->ended);
    pthread_mutex_destroy(&all->lock);
    free(all);
}

/* The folder of the files; NULL: errno has the reason. The list is locked, as for the next four
 * functions. */
static const char *folder_of(films *all)
{
    const char *temporary = getenv("TMPDIR");
    char path[4096];
    if (all->folder)
        return all->folder;
    errno = ENAMETOOLONG;
    const int length = snprintf(path, sizeof path, "%s/cvol-view-XXXXXX",
                                temporary && *temporary ? temporary : "/tmp");
    if (length < (int)sizeof path && mkdtemp(path))
        all->folder = strdup(path);
    return all->folder;
}

static film *find(const films *all, const char *id)
{
    for (int i = 0; i < all->count; i++)
        if (!strcmp(all->list[i]->id, id))
            return all->list[i];
    return NULL;
}

/* Removes an animation from the list; the caller gets the list's reference. */
static film *forget(films *all, int place)
{
    film *f = all->list[place];
    f->removed = 1;
    pthread_cond_broadcast(&all->ended);
    memmove(all->list + place, all->list + place + 1,
            (size_t)(all->count - place - 1) * sizeof *all->list);
    all->count--;
    return f;
}

/* Makes room for one more; *older: a finished animation that was removed for that. 0: no room. */
static int make_room(films *all, film **older)
{
    for (int i = 0; i < all->count && all->count == FILMS_MAX; i++)
        if (all->list[i]->state != FILM_RUNNING)
            *older = forget(all, i);
    return all->count < FILMS_MAX && !all->closing;
}

static json_t *describe(const film *f)
{
    static const char *const states[] = {"running", "done", "failed"};
    json_t *error = answer_text(f->state == FILM_FAILED ? f->message : NULL);
    return json_pack("{s:s, s:s, s:f, s:I, s:o}", "id", f->id, "state", states[f->state],
                     "fraction", f->fraction, "bytes", (json_int_t)f->bytes, "error",
                     error ? error : json_string("unknown error"));
}

/* Names the animation, starts its thread and adds it to the list, which is locked. */
static answer start(films *all, film *f)
{
    pthread_t thread;
    const char *folder = folder_of(all);
    if (!folder)
        return answer_error(500,
                            "cannot make a folder for animations: %s; set TMPDIR to another place",
                            strerror(errno));
    snprintf(f->id, sizeof f->id, "f%d", all->next_id++);
    const size_t bytes = strlen(folder) + sizeof f->id + 16;
    f->path = malloc(bytes);
    if (!f->path)
        return answer_error(500, "not enough memory for an animation");
    snprintf(f->path, bytes, "%s/%s%s", folder, f->id, f->settings.format->ending);
    f->holders = 2; /* the list and the thread */
    if (pthread_create(&thread, NULL, make, f)) {
        f->holders = 1;
        return answer_error(500, "cannot start a thread for the animation");
    }
    pthread_detach(thread);
    all->makers++;
    all->list[all->count++] = f;
    return answer_json(202, describe(f));
}

/* ---- requests ---------------------------------------------------------------------------------
 */

static void take_format(film_settings *out, const viewer_movies *movies, fields *f)
{
    char name[16] = "", names[64] = "";
    const film_format *format;
    take_text(f, "format", name, sizeof name);
    for (int i = 0; (format = film_format_at(i, movies)); i++) {
        const size_t length = strlen(names);
        snprintf(names + length, sizeof names - length, "%s%s", i ? " " : "", format->name);
    }
    out->format = film_format_find(name[0] ? name : "gif", movies);
    if (!out->format)
        fields_fail(f, "format is '%s', must be one of: %s", name, names);
}

/* 0, or a status of HTTP, with the message in f->error. */
static int take(film_settings *out, const service *s, fields *f)
{
    const viewer_movies *movies = s->options->movies;
    out->frames = 72;
    out->degrees = 360;
    out->options = cvol_film_options_defaults();
    fields inner = take_object(f, "view", "view.");
    if (!inner.object)
        fields_fail(f, "view is missing: give the view of the animation");
    const int status = fields_ok(f) ? view_take(&out->view, s->volumes, &inner) : 400;
    fields_end(&inner);
    if (status)
        return status;
    take_bool(f, "over_time", &out->over_time);
    if (out->over_time) {
        out->degrees = 0;
        out->frames = out->view.volume->times;
    }
    const int has_frames = take_integer(f, "frames", &out->frames, 1, FILM_FRAMES_MAX);
    if (out->over_time && (has_frames || out->frames > FILM_FRAMES_MAX || out->frames < 2))
        fields_fail(f,
                    "over_time makes one picture of each time: the volume has %d, must have 2 to "
                    "%d, and frames must be left out",
                    out->view.volume->times, FILM_FRAMES_MAX);
    take_number(f, "fps", &out->options.frames_per_second, 0.1, 50);
    take_number(f, "degrees", &out->degrees, -36000, 36000);
    take_integer(f, "quality", &out->options.quality, 0, 100);
    take_format(out, movies, f);
    const double pixels = (double)out->view.options.width * out->view.options.height * out->frames;
    if (pixels > FILM_PIXELS_MAX)
        fields_fail(f, "all frames together have %.3g pixels, must have at most %.3g", pixels,
                    FILM_PIXELS_MAX);
    fields_end(f);
    return fields_ok(f) ? 0 : 400;
}

answer film_post(request *r)
{
    films *all = r->service->films;
    char error[512] = "";
    json_t *body;
    fields_parse(&body, r->body, r->body_bytes, error, sizeof error);
    fields f = {body, NULL, "", error, sizeof error};
    film *new_film = body ? calloc(1, sizeof *new_film) : NULL, *older = NULL;
    const int status = new_film ? take(&new_film->settings, r->service, &f) : 400;
    json_decref(body);
    answer a;
    if (!new_film)
        return answer_error(400, "%s", error[0] ? error : "not enough memory for a request");
    new_film->all = all;
    new_film->holders = 1;
    if (status) {
        a = answer_error(status, "%s", error);
    } else {
        pthread_mutex_lock(&all->lock);
        a = make_room(all, &older)
                ? start(all, new_film)
                : answer_error(429, "%d animations are already in progress: wait or remove one",
                               FILMS_MAX);
        pthread_mutex_unlock(&all->lock);
    }
    if (a.status != 202)
        release(new_film);
    if (older)
        release(older);
    return a;
}

static answer no_film(const request *r)
{
    return answer_error(404, "there is no animation '%s'", r->name);
}

answer film_get(request *r)
{
    films *all = r->service->films;
    pthread_mutex_lock(&all->lock);
    const film *f = find(all, r->name);
    json_t *object = f ? describe(f) : NULL;
    pthread_mutex_unlock(&all->lock);
    return f ? answer_json(200, object) : no_film(r);
}

answer film_delete(request *r)
{
    films *all = r->service->films;
    film *f = NULL;
    pthread_mutex_lock(&all->lock);
    for (int i = 0; i < all->count && !f; i++)
        if (!strcmp(all->list[i]->id, r->name))
            f = forget(all, i);
    pthread_mutex_unlock(&all->lock);
    if (!f)
        return no_film(r);
    release(f);
    return answer_json(200, json_pack("{s:s}", "removed", r->name));
}

/* Sets the name of the download: the name of the volume, with '_' for special characters. */
static void name_file(answer *a, const film *f)
{
    const char *name = f->settings.view.volume->name, *dot = strrchr(name, '.');
    const size_t length = dot && dot > name ? (size_t)(dot - name) : strlen(name);
    char text[160];
    size_t size = (size_t)snprintf(text, sizeof text, "attachment; filename=\"");
    for (size_t i = 0; i < length && i < 80; i++) {
        const unsigned char c = (unsigned char)name[i];
        const int plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
                          (c >= 'A' && c <= 'Z') || c == '-';
        text[size++] = plain ? (char)c : '_';
    }
    snprintf(text + size, sizeof text - size, "%s\"", f->settings.format->ending);
    answer_header(a, "Content-Disposition", text);
}

answer film_file_get(request *r)
{
    films *all = r->service->films;
    pthread_mutex_lock(&all->lock);
    film *f = find(all, r->name);
    const film_state state = f ? f->state : FILM_FAILED;
    if (f)
        f->holders++;
    pthread_mutex_unlock(&all->lock);
    if (!f)
        return no_film(r);
    answer a;
    const int fd = state == FILM_DONE ? open(f->path, O_RDONLY | O_CLOEXEC) : -1;
    if (state != FILM_DONE)
        a = answer_error(409, "animation '%s' is not complete; see api/1/films/%s", f->id, f->id);
    else if (fd < 0)
        a = answer_error(500, "cannot read animation '%s': %s", f->id, strerror(errno));
    else {
        a = (answer){
            .status = 200, .type = f->settings.format->type, .size = (size_t)f->bytes, .fd = fd};
        name_file(&a, f);
    }
    release(f);
    return a;
}
