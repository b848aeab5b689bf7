/* The volumes in the viewer. */
#include "viewer/volumes/volumes.h"
#include "viewer/volumes/colours.h"
#include "viewer/volumes/labels.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "viewer/base/answer.h"
#include "viewer/base/background.h"
#include "viewer/base/priority.h"
#include "viewer/volumes/overlays.h"
#include "viewer/volumes/times.h"
#include "viewer/volumes/volume_read.h"
#include "viewer/volumes/volume_renderers.h"

struct volumes {
    const viewer_options *options;
    pthread_mutex_t lock;
    pthread_cond_t ended; /* signalled when a maker ends or a copy is removed */
    shown_volume *list[VOLUMES_MAX + COPIES_MAX];
    int count, next_id, makers, copying, closing; /* copying: 1 while a copy is made */
    int copies;                                   /* copies in memory, removed ones too */
    kept_memory kept;
    open_times *times;
    shown_colours *colours;
};

/* ---- making --------------------------------------------------------------------------------- */

static int on_progress(void *user, const char *what, double fraction)
{
    shown_volume *v = user;
    pthread_mutex_lock(&v->all->lock);
    snprintf(v->doing, sizeof v->doing, "%s", what ? what : "");
    v->fraction = fraction;
    const int stop = v->all->closing || v->removed;
    pthread_mutex_unlock(&v->all->lock);
    return stop;
}

void volume_set_state(shown_volume *v, volume_state state)
{
    pthread_mutex_lock(&v->all->lock);
    v->state = state;
    v->fraction = 0;
    pthread_mutex_unlock(&v->all->lock);
}

static void make(shown_volume *v, const viewer_options *options)
{
    cvol_context *context = cvol_context_create();
    int code = context ? CVOL_OK : CVOL_ERROR_MEMORY;
    if (context) {
        cvol_context_set_threads(context, options->threads);
        cvol_context_set_progress(context, on_progress, v);
        code = v->parent ? volume_make_copy(context, v, options) : volume_read(context, v, options);
    }
    char *message = code ? strdup(context ? answer_message(context, code) : "not enough memory")
                         : NULL;
    pthread_mutex_lock(&v->all->lock);
    v->error = message;
    v->state = code ? VOLUME_FAILED : VOLUME_READY;
    pthread_mutex_unlock(&v->all->lock);
    if (!code && !options->is_cold)
        volume_warm(context, v);
    cvol_context_free(context);
}

static int is_closing(volumes *all)
{
    pthread_mutex_lock(&all->lock);
    const int closing = all->closing;
    pthread_mutex_unlock(&all->lock);
    return closing;
}

/* One thread reads all volumes of the command line. */
static void *make_all(void *argument)
{
    volumes *all = argument;
    for (int i = 0; i < all->options->volume_count && !is_closing(all); i++)
        make(all->list[i], all->options);
    return NULL;
}

static void end_maker(volumes *all)
{
    pthread_mutex_lock(&all->lock);
    all->makers--;
    pthread_cond_broadcast(&all->ended);
    pthread_mutex_unlock(&all->lock);
}

static void *run_reader(void *all)
{
    make_all(all);
    end_maker(all);
    return NULL;
}

/* Waits until no other copy is made; 0: this copy was removed. */
static int take_turn(shown_volume *copy)
{
    volumes *all = copy->all;
    pthread_mutex_lock(&all->lock);
    while (all->copying && !copy->removed && !all->closing)
        pthread_cond_wait(&all->ended, &all->lock);
    const int wanted = !copy->removed && !all->closing;
    if (wanted)
        all->copying = 1;
    pthread_mutex_unlock(&all->lock);
    return wanted;
}

static void *run_copier(void *copy)
{
    shown_volume *v = copy;
    volumes *all = v->all;
    lower_thread_priority();
    if (take_turn(v)) {
        make(v, all->options);
        pthread_mutex_lock(&all->lock);
        all->copying = 0;
        pthread_cond_broadcast(&all->ended);
        pthread_mutex_unlock(&all->lock);
    }
    volume_release(v);
    end_maker(all);
    return NULL;
}

/* Starts a thread; 0 on success. */
static int start_maker(volumes *all, void *(*run)(void *), void *argument)
{
    pthread_mutex_lock(&all->lock);
    all->makers++;
    pthread_mutex_unlock(&all->lock);
    if (!run_in_background(run, argument))
        return 0;
    end_maker(all);
    return -1;
}

/* ---- the registry --------------------------------------------------------------------------- */

static void free_volume(shown_volume *v)
{
    if (!v)
        return;
    volume_free_renderers(v);
    labels_free(v->labels);
    overlays_free(v);
    cvol_array_free(v->array);
    cvol_volume_free(v->dense);
    pthread_mutex_destroy(&v->idle_lock);
    if (v->parent) {
        pthread_mutex_lock(&v->all->lock);
        v->all->copies--;
        pthread_mutex_unlock(&v->all->lock);
    }
    volume_release(v->parent);
    volume_release(v->series);
    free(v->path);
    free(v->name);
    free(v->error);
    free(v);
}

const char *volume_last_name(const char *path)
{
    size_t end = strlen(path);
    while (end && path[end - 1] == '/')
        end--;
    while (end && path[end - 1] != '/')
        end--;
    return path + end;
}

static shown_volume *new_volume(volumes *all, const char *path, const char *name)
{
    shown_volume *v = calloc(1, sizeof *v);
    if (!v)
        return NULL;
    pthread_mutex_init(&v->idle_lock, NULL);
    v->all = all;
    v->holders = 1; /* the registry */
    v->times = 1;
    v->psnr_db = v->max_error = NAN;
    v->path = strdup(path);
    v->name = strdup(name);
    if (v->path && v->name) {
        v->file = volume_last_name(v->path);
        return v;
    }
    free_volume(v);
    return NULL;
}

/* A later time of a volume, not read yet. */
static shown_volume *new_time(shown_volume *series, int time)
{
    shown_volume *v = new_volume(series->all, series->path, series->name);
    if (!v)
        return NULL;
    memcpy(v->id, series->id, sizeof v->id);
    v->read = series->read;
    v->read.has_index = 1;
    v->read.index += time;
    v->level = series->level;
    v->named = series->named;
    v->named_count = series->named_count;
    v->channel = series->channel;
    v->series = series;
    volume_hold(series);
    return v;
}

int volume_read_time(cvol_context *context, shown_volume **out, shown_volume *series, int time)
{
    *out = new_time(series, time);
    const int code = *out ? volume_read(context, *out, series->all->options) : CVOL_ERROR_MEMORY;
    if (!code) {
        volume_set_state(*out, VOLUME_READY);
        return code;
    }
    volume_release(*out);
    *out = NULL;
    return code;
}

volumes *volumes_open(const viewer_options *options)
{
    volumes *all = calloc(1, sizeof *all);
    if (!all)
        return NULL;
    all->options = options;
    pthread_mutex_init(&all->lock, NULL);
    pthread_cond_init(&all->ended, NULL);
    pthread_mutex_init(&all->kept.lock, NULL);
    all->kept.most = (uint64_t)(1e6 * options->keep_mb);
    all->times = times_open((uint64_t)(1e6 * options->times_mb));
    all->colours = colours_open();
    for (int i = 0; i < options->volume_count; i++) {
        const viewer_volume *one = &options->volumes[i];
        shown_volume *v = new_volume(all, one->path,
                                     one->name ? one->name : volume_last_name(one->path));
        if (!v)
            break;
        v->read = one->read;
        v->level = one->level;
        v->brick_levels = one->brick_levels;
        v->brick_count = one->brick_count;
        v->named = one->labels;
        v->named_count = one->label_count;
        v->times = one->times > 1 ? one->times : 1;
        v->time_values = one->time_values;
        v->time_unit = one->time_unit;
        v->channel = one->channel;
        snprintf(v->id, sizeof v->id, "%d", i);
        all->list[all->count++] = v;
    }
    all->next_id = all->count;
    if (all->times && all->colours && all->count == options->volume_count &&
        !start_maker(all, run_reader, all))
        return all;
    volumes_close(all);
    return NULL;
}

void volumes_close(volumes *all)
{
    if (!all)
        return;
    pthread_mutex_lock(&all->lock);
    all->closing = 1;
    pthread_cond_broadcast(&all->ended);
    while (all->makers)
        pthread_cond_wait(&all->ended, &all->lock);
    pthread_mutex_unlock(&all->lock);
    colours_close(all->colours);
    while (all->count)
        volume_release(all->list[--all->count]);
    times_close(all->times); /* volumes count the open times until they are freed */
    pthread_cond_destroy(&all->ended);
    pthread_mutex_destroy(&all->kept.lock);
    pthread_mutex_destroy(&all->lock);
    free(all);
}

shown_volume *volumes_hold(volumes *all, const char *id)
{
    shown_volume *found = NULL;
    pthread_mutex_lock(&all->lock);
    for (int i = 0; i < all->count && !found; i++)
        if (!strcmp(all->list[i]->id, id)) {
            found = all->list[i];
            found->holders++;
        }
    pthread_mutex_unlock(&all->lock);
    return found;
}

void volume_hold(shown_volume *v)
{
    pthread_mutex_lock(&v->all->lock);
    v->holders++;
    pthread_mutex_unlock(&v->all->lock);
}

void volume_release(shown_volume *v)
{
    if (!v)
        return;
    volumes *all = v->all;
    pthread_mutex_lock(&all->lock);
    const int last = --v->holders == 0;
    pthread_mutex_unlock(&all->lock);
    if (last)
        free_volume(v);
}

int volume_is_ready(shown_volume *v)
{
    return volume_look_at(v).state == VOLUME_READY;
}

/* Removes a volume from the list, which is locked; references to it stay valid. */
static void forget(volumes *all, int place)
{
    shown_volume *v = all->list[place];
    v->removed = 1;
    pthread_cond_broadcast(&all->ended);
    memmove(all->list + place, all->list + place + 1,
            (size_t)(all->count - place - 1) * sizeof *all->list);
    all->count--;
}

/* Removes the copy of a viewer from the list, which is locked; the caller gets the reference. */
static shown_volume *take_copy(volumes *all, const shown_volume *parent, const char *who)
{
    for (int i = 0; i < all->count; i++) {
        shown_volume *v = all->list[i];
        if (v->parent == parent && who[0] && !strcmp(v->viewer, who)) {
            forget(all, i);
            return v;
        }
    }
    return NULL;
}

shown_volume *volumes_copy(volumes *all, shown_volume *parent, int time,
                           const cvol_compress_options *options, const char *who)
{
    shown_volume *v = new_volume(all, parent->path, parent->name), *old = NULL;
    if (!v)
        return NULL;
    v->state = VOLUME_COMPRESSING;
    v->copied_time = time;
    v->copy_options = *options;
    snprintf(v->viewer, sizeof v->viewer, "%s", who);
    pthread_mutex_lock(&all->lock);
    old = take_copy(all, parent, who);
    int copies = 0;
    for (int i = 0; i < all->count; i++)
        copies += all->list[i]->parent != NULL;
    /* Removed copies stay in memory while another copy or a picture holds them. */
    const int room = copies < COPIES_MAX && all->copies < 2 * COPIES_MAX && !all->closing;
    if (room) {
        all->copies++;
        snprintf(v->id, sizeof v->id, "%d", all->next_id++);
        v->parent = parent;
        parent->holders++;
        v->holders += 2; /* the caller and the thread */
        all->list[all->count++] = v;
    }
    pthread_mutex_unlock(&all->lock);
    volume_release(old);
    if (!room) {
        free_volume(v);
        return NULL;
    }
    if (!start_maker(all, run_copier, v))
        return v;
    volumes_remove(all, v);
    volume_release(v); /* of the thread */
    volume_release(v); /* of the caller */
    return NULL;
}

int volumes_remove(volumes *all, shown_volume *v)
{
    int found = 0;
    pthread_mutex_lock(&all->lock);
    for (int i = 0; i < all->count && v->parent && !found; i++)
        if (all->list[i] == v) {
            forget(all, i);
            found = 1;
        }
    pthread_mutex_unlock(&all->lock);
    if (found)
        volume_release(v); /* of the registry */
    return found ? 0 : -1;
}

uint64_t volumes_resident_bytes(volumes *all)
{
    uint64_t bytes = 0;
    times_count(all->times, &bytes);
    pthread_mutex_lock(&all->lock);
    for (int i = 0; i < all->count; i++) {
        const shown_volume *v = all->list[i];
        cvol_array_info info;
        if (v->state != VOLUME_READY)
            continue;
        cvol_array_get_info(&info, v->array);
        bytes += info.resident_bytes + (v->dense ? v->raw_bytes : 0) + overlays_resident_bytes(v);
    }
    pthread_mutex_unlock(&all->lock);
    return bytes;
}

int volumes_count(volumes *all)
{
    pthread_mutex_lock(&all->lock);
    const int count = all->count;
    pthread_mutex_unlock(&all->lock);
    uint64_t bytes;
    return count + times_count(all->times, &bytes);
}

open_times *volumes_times(volumes *all)
{
    return all->times;
}

shown_colours *volumes_colours(volumes *all)
{
    return all->colours;
}

const viewer_options *volumes_options(const volumes *all)
{
    return all->options;
}

kept_memory *volumes_kept(volumes *all)
{
    return &all->kept;
}

volume_look volume_look_at(shown_volume *v)
{
    volume_look look;
    pthread_mutex_lock(&v->all->lock);
    look = (volume_look){.state = v->state, .fraction = v->fraction, .error = v->error};
    snprintf(look.doing, sizeof look.doing, "%s", v->doing);
    pthread_mutex_unlock(&v->all->lock);
    return look;
}

void volume_say_unready(char *text, size_t size, shown_volume *v, const char *id)
{
    const volume_look look = volume_look_at(v);
    if (look.state == VOLUME_FAILED && look.error)
        snprintf(text, size, "%s", look.error);
    else
        snprintf(text, size, "volume '%s' is not ready; see api/1/volumes/%s", id, id);
}

int volumes_hold_all(volumes *all, shown_volume *held[VOLUMES_MAX + COPIES_MAX])
{
    pthread_mutex_lock(&all->lock);
    const int count = all->count;
    for (int i = 0; i < count; i++) {
        held[i] = all->list[i];
        held[i]->holders++;
    }
    pthread_mutex_unlock(&all->lock);
    return count;
}
