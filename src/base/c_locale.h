/* Decimal points in texts, whatever the locale of the program. */
#ifndef CVOL_BASE_C_LOCALE_H
#define CVOL_BASE_C_LOCALE_H

#include "cvol/base.h"

typedef struct cvol_c_locale {
    void *c, *before; /* locale_t */
} cvol_c_locale;

/* Gives the calling thread the locale C until cvol_c_locale_leave. Errors: MEMORY. */
int cvol_c_locale_enter(cvol_context *context, cvol_c_locale *locale);
void cvol_c_locale_leave(const cvol_c_locale *locale);

#endif
