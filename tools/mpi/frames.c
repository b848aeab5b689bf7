/* The stages of pictures: frames.h. */
#include "tools/mpi/frames.h"

static json_t *frames;

void note_frame(const cvol_mpi_render_report *r, double read_s)
{
    if (!frames)
        frames = json_array();
    if (frames)
        json_array_append_new(
            frames,
            json_pack("{s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:I, s:I, s:I, s:I}", "read_s",
                      read_s, "total_s", r->total_s, "draw_s", r->draw_s, "draw_cpu_s",
                      r->draw_cpu_s, "all_cpu_s", r->all_cpu_s, "wait_s", r->wait_s, "composite_s",
                      r->composite_s, "gather_s", r->gather_s, "warp_s", r->warp_s, "messages",
                      (json_int_t)r->messages, "bytes", (json_int_t)r->bytes, "most_messages",
                      (json_int_t)r->most_messages, "most_bytes", (json_int_t)r->most_bytes));
}

json_t *take_frames(void)
{
    json_t *taken = frames;
    frames = NULL;
    return taken;
}
