/* Plans of writers: files of detached samples. */
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "volume/io/stored.h"
#include "volume/io/text.h"

void cvol_write_plan_free(cvol_write_plan *plan)
{
    cvol_bytes_free(&plan->header);
    cvol_bytes_free(&plan->trailer);
    free(plan->data_path);
    plan->data_path = NULL;
}

static int is_plain_name(const char *name)
{
    size_t length = strlen(name);
    for (size_t i = 0; i < length; i++)
        if ((unsigned char)name[i] < ' ' || name[i] == 0x7f || name[i] == '%')
            return 0;
    return length && name[0] != ' ' && name[length - 1] != ' ';
}

int cvol_write_plan_detach(cvol_context *context, cvol_write_plan *plan, const char *header_path,
                           const char *ending)
{
    const char *name = cvol_input_name(header_path), *dot = strrchr(name, '.');
    size_t stem = dot ? (size_t)(dot - header_path) : strlen(header_path);
    plan->data_path = malloc(stem + strlen(ending) + 1);
    if (!plan->data_path)
        return cvol_fail_memory(context, stem, header_path);
    memcpy(plan->data_path, header_path, stem);
    memcpy(plan->data_path + stem, ending, strlen(ending) + 1);
    if (is_plain_name(cvol_input_name(plan->data_path)))
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                     "%s: a header cannot hold the data file's name '%s'", header_path,
                     cvol_input_name(plan->data_path));
}

int cvol_write_plan_text(cvol_context *context, cvol_write_plan *plan, const char *header_path,
                         const char *detached, cvol_encoding encoding, const char **data_name)
{
    *data_name = NULL;
    if (!cvol_text_ends(header_path, detached)) {
        plan->encoding = encoding;
        return CVOL_OK;
    }
    const int code = cvol_write_plan_detach(context, plan, header_path, ".raw");
    if (!code)
        *data_name = cvol_input_name(plan->data_path);
    return code;
}
