/* The times of volumes. A list in order of use; the least recently used ones are released first. */
#include "viewer/volumes/times.h"

#include <stdlib.h>

typedef struct open_time {
    const shown_volume *series;
    int time;
    shown_volume *volume;        /* held; NULL: a thread reads it */
    uint64_t array_bytes, bytes; /* of the array; and with what its renderers may take */
    struct open_time *next;
} open_time;

struct open_times {
    pthread_mutex_t lock;
    pthread_cond_t ended; /* signalled when a thread has read a time, or failed */
    uint64_t most, array_bytes, bytes;
    int count;
    open_time *first; /* used last */
};

open_times *times_open(uint64_t most)
{
    open_times *all = calloc(1, sizeof *all);
    if (!all)
        return NULL;
    all->most = most;
    pthread_mutex_init(&all->lock, NULL);
    pthread_cond_init(&all->ended, NULL);
    return all;
}

static open_time *take_first(open_times *all)
{
    open_time *t = all->first;
    all->first = t->next;
    return t;
}

void times_close(open_times *all)
{
    if (!all)
        return;
    while (all->first) {
        open_time *t = take_first(all);
        volume_release(t->volume);
        free(t);
    }
    pthread_cond_destroy(&all->ended);
    pthread_mutex_destroy(&all->lock);
    free(all);
}

int times_count(open_times *all, uint64_t *bytes)
{
    pthread_mutex_lock(&all->lock);
    const int count = all->count;
    *bytes = all->array_bytes;
    pthread_mutex_unlock(&all->lock);
    return count;
}

/* Moves the entry of a time to the front of the list, which is locked; NULL: there is none. */
static open_time *find(open_times *all, const shown_volume *series, int time)
{
    for (open_time **place = &all->first; *place; place = &(*place)->next) {
        open_time *t = *place;
        if (t->series != series || t->time != time)
            continue;
        *place = t->next;
        t->next = all->first;
        all->first = t;
        return t;
    }
    return NULL;
}

static void remove_entry(open_times *all, const open_time *entry)
{
    for (open_time **place = &all->first; *place; place = &(*place)->next)
        if (*place == entry) {
            *place = entry->next;
            break;
        }
}

/* Removes the entry that was used least recently, if there are too many bytes; NULL: there is room.
 */
static open_time *take_surplus(open_times *all)
{
    open_time *last = NULL;
    if (all->count <= TIMES_LEAST || all->bytes <= all->most)
        return NULL;
    for (open_time *t = all->first; t; t = t->next)
        if (t->volume)
            last = t;
    if (last) {
        remove_entry(all, last);
        all->count--;
        all->array_bytes -= last->array_bytes;
        all->bytes -= last->bytes;
    }
    return last;
}

static void release_surplus(open_times *all)
{
    for (;;) {
        pthread_mutex_lock(&all->lock);
        open_time *t = take_surplus(all);
        pthread_mutex_unlock(&all->lock);
        if (!t)
            return;
        volume_release(t->volume);
        free(t);
    }
}

/* A renderer takes about half of this for a sample, besides its block cache. */
enum { RENDERER_SAMPLE_BYTES = 4 };

static void count_bytes(open_time *entry)
{
    const shown_volume *v = entry->volume;
    const uint64_t samples = cvol_grid_samples(&v->grid);
    cvol_array_info info;
    cvol_array_get_info(&info, v->array);
    entry->array_bytes = info.resident_bytes + (v->labels ? samples : 0);
    entry->bytes = entry->array_bytes + RENDERER_SAMPLE_BYTES * samples;
}

/* Ends an entry whose time was read, or could not be read. */
static void end_entry(open_times *all, open_time *entry, shown_volume *volume)
{
    pthread_mutex_lock(&all->lock);
    if (volume) {
        volume_hold(volume);
        entry->volume = volume;
        count_bytes(entry);
        all->array_bytes += entry->array_bytes;
        all->bytes += entry->bytes;
        all->count++;
    } else {
        remove_entry(all, entry);
    }
    pthread_cond_broadcast(&all->ended);
    pthread_mutex_unlock(&all->lock);
    if (!volume)
        free(entry);
}

int times_hold(cvol_context *context, shown_volume **out, shown_volume *series, int time)
{
    open_times *all = volumes_times(series->all);
    if (!time) {
        volume_hold(series);
        *out = series;
        return CVOL_OK;
    }
    pthread_mutex_lock(&all->lock);
    open_time *entry;
    while ((entry = find(all, series, time)) && !entry->volume)
        pthread_cond_wait(&all->ended, &all->lock);
    *out = entry ? entry->volume : NULL;
    if (*out)
        volume_hold(*out);
    else if ((entry = calloc(1, sizeof *entry)))
        *entry = (open_time){.series = series, .time = time, .next = all->first};
    if (entry && !*out)
        all->first = entry;
    pthread_mutex_unlock(&all->lock);
    if (*out || !entry)
        return *out ? CVOL_OK : CVOL_ERROR_MEMORY;
    const int code = volume_read_time(context, out, series, time);
    end_entry(all, entry, *out);
    release_surplus(all);
    return code;
}
