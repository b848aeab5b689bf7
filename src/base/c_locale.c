#define _GNU_SOURCE
#include "base/c_locale.h"

#include <locale.h>

#include "base/context.h"

int cvol_c_locale_enter(cvol_context *context, cvol_c_locale *locale)
{
    locale->c = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (!locale->c)
        return cvol_fail_memory(context, 0, "a locale");
    locale->before = uselocale(locale->c);
    return CVOL_OK;
}

void cvol_c_locale_leave(const cvol_c_locale *locale)
{
    uselocale(locale->before);
    freelocale(locale->c);
}
