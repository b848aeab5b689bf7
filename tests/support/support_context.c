#include "test.h"

#include "support_context.h"

cvol_context *context;

int context_setup(void **state)
{
    (void)state;
    context = cvol_context_create();
    return context ? 0 : -1;
}

static int set_up_with(void **state, int threads)
{
    const int code = context_setup(state);
    if (!code)
        cvol_context_set_threads(context, threads);
    return code;
}

int context_setup_one(void **state)
{
    return set_up_with(state, 1);
}

int context_setup_two(void **state)
{
    return set_up_with(state, 2);
}

int context_teardown(void **state)
{
    (void)state;
    cvol_context_free(context);
    return 0;
}

void check_ok(int code)
{
    if (code)
        fail_msg("%d: %s", code, cvol_context_message(context));
}
