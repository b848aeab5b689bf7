#include "support_context.h"

cvol_context *context;

int context_setup(void **state)
{
    (void)state;
    context = cvol_context_create();
    return context ? 0 : -1;
}

int context_setup_two(void **state)
{
    const int code = context_setup(state);
    if (!code)
        cvol_context_set_threads(context, 2);
    return code;
}

int context_teardown(void **state)
{
    (void)state;
    cvol_context_destroy(context);
    return 0;
}
