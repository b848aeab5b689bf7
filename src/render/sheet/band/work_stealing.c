/* Threads share lines: see work_stealing.h. */
#include "render/sheet/band/work_stealing.h"

#include <sched.h>
#include <string.h>

#include "base/context.h"
#include "base/thread.h"

/* Bands with fewer lines, or fewer lines times layers, are not divided: both halves need the blocks
 * between them, and must evaluate the waiting slices of the layer before once more. */
#define MIN_LINES (2 * CVOL_TILE)
#define MIN_LEFT (8 * CVOL_TILE)

int cvol_work_stealing_lines(const cvol_sheet_plan *plan, int threads)
{
    /* For a level nothing is evaluated twice. */
    const int least = plan->level ? CVOL_TILE : 48;
    int lines = (plan->height + threads - 1) / threads;
    lines = lines < least && threads > 1 ? least : lines;
    return (lines + CVOL_TILE - 1) / CVOL_TILE * CVOL_TILE;
}

/* ---- the victim ------------------------------------------------------------------------------ */

static int left_of(const cvol_work_stealing *share, const cvol_band *band)
{
    const int lines = band->end - band->begin,
              layers = (int)(share->frame->plan->layers - band->step);
    return lines < MIN_LINES || lines * layers < MIN_LEFT ? 0 : lines * layers;
}

static void answer(cvol_work_stealing *share, int thief, int with)
{
    atomic_store_explicit(&share->bands[thief - 1].worker.answer, with, memory_order_release);
}

void cvol_work_stealing_tile(cvol_work_stealing *share, int thread, cvol_band *band, int next)
{
    cvol_band_memory *own = &share->bands[thread];
    const int thief = atomic_load_explicit(&own->worker.thief, memory_order_acquire);
    if (thief <= 0)
        return;
    const int lines = band->end - band->begin,
              half = band->begin + (lines / 2 + CVOL_TILE - 1) / CVOL_TILE * CVOL_TILE,
              from = next > half ? next : half;
    const int left = left_of(share, band);
    if (left && band->end - from < lines / 4) /* in the next layer */
        return;
    if (left && from < band->end) {
        cvol_band_memory *other = &share->bands[thief - 1];
        other->worker.given = (cvol_band){from, band->end, band->step};
        atomic_store(&other->worker.left, left_of(share, &other->worker.given));
        memcpy(other->pending, own->pending + (from - band->begin) / CVOL_TILE,
               (size_t)(band->end - from + CVOL_TILE - 1) / CVOL_TILE);
        band->end = from;
    }
    atomic_store(&own->worker.left, left_of(share, band));
    atomic_store(&own->worker.thief, 0);
    answer(share, thief, left ? 1 : -1);
}

int cvol_work_stealing_layer(cvol_work_stealing *share, int thread, const cvol_band *band)
{
    const cvol_sheet_frame *frame = share->frame;
    const ptrdiff_t all = (ptrdiff_t)frame->plan->height * (ptrdiff_t)frame->plan->layers;
    atomic_store_explicit(&share->bands[thread].worker.left, left_of(share, band),
                          memory_order_relaxed);
    if (atomic_load_explicit(&share->cancelled, memory_order_relaxed))
        return 0;
    if (thread)
        return 1;
    const double part = (double)atomic_load_explicit(&share->drawn, memory_order_relaxed) /
                        (double)all;
    const int code = cvol_report_progress(share->context, "rendering",
                                          frame->progress[0] + frame->progress[1] * part);
    if (code)
        atomic_store(&share->cancelled, code);
    return !code;
}

/* ---- the thief ------------------------------------------------------------------------------- */

static void back_off(int *times)
{
    if (++*times % 16 == 0)
        sched_yield();
#if defined(__x86_64__)
    else
        __builtin_ia32_pause();
#endif
}

/* The thread with the most lines left and no thief, -1 if there is none; *any: 1 if some thread has
 * lines. */
static int choose_victim(int *any, const cvol_work_stealing *share, int thread)
{
    int most = 0, victim = -1;
    *any = 0;
    for (int i = 0; i < share->threads; i++) {
        const cvol_worker *worker = &share->bands[i].worker;
        const int left = i == thread ? 0 : atomic_load(&worker->left);
        *any |= left > 0;
        if (left > most && atomic_load(&worker->thief) == 0) {
            most = left;
            victim = i;
        }
    }
    return victim;
}

/* Takes some lines of another thread; 0 if none has any to give. */
static int ask(cvol_band *out, cvol_work_stealing *share, int thread)
{
    cvol_worker *own = &share->bands[thread].worker;
    int any, times = 0;
    for (;;) {
        const int victim = choose_victim(&any, share, thread);
        if (!any || atomic_load(&share->cancelled))
            return 0;
        int no_thief = 0;
        atomic_store(&own->answer, 0);
        if (victim < 0 || !atomic_compare_exchange_strong(&share->bands[victim].worker.thief,
                                                          &no_thief, thread + 1)) {
            back_off(&times);
            continue;
        }
        int answered;
        while (!(answered = atomic_load_explicit(&own->answer, memory_order_acquire)))
            back_off(&times);
        if (answered > 0) {
            *out = own->given;
            return 1;
        }
    }
}

static int next_band(cvol_band *out, cvol_work_stealing *share, int thread)
{
    const int height = share->frame->plan->height,
              begin = share->lines * atomic_fetch_add(&share->next, 1);
    if (begin >= height)
        return !share->frame->counts && ask(out, share, thread);
    *out = (cvol_band){begin, begin + share->lines < height ? begin + share->lines : height, 0};
    return 1;
}

static void draw_some(cvol_work_stealing *share, int thread)
{
    cvol_worker *worker = &share->bands[thread].worker;
    cvol_band band;
    while (next_band(&band, share, thread)) {
        atomic_store(&worker->left, left_of(share, &band));
        atomic_store(&worker->thief, 0);
        share->draw(share, thread, &band);
        atomic_store(&worker->left, 0);
        const int thief = atomic_exchange(&worker->thief, -1);
        if (thief > 0)
            answer(share, thief, -1);
    }
}

int cvol_work_stealing_draw(cvol_context *context, const cvol_sheet_frame *frame,
                            cvol_band_memory *bands,
                            void (*draw)(cvol_work_stealing *share, int thread, cvol_band *band),
                            int threads, int lines)
{
    cvol_work_stealing share = {.context = context,
                                .frame = frame,
                                .bands = bands,
                                .draw = draw,
                                .threads = threads,
                                .lines = lines};
    for (int i = 0; i < threads; i++) {
        atomic_store(&bands[i].worker.left, 0);
        atomic_store(&bands[i].worker.thief, -1);
    }
#pragma omp parallel num_threads(threads)
    draw_some(&share, cvol_thread_index());
    const int code = atomic_load(&share.cancelled);
    return code ? code
                : cvol_report_progress(context, "rendering",
                                       frame->progress[0] + frame->progress[1]);
}
