#include "test.h"

#include "support_container.h"

#include "base/context.h"
#include "codec/container/container.h"
#include "support.h"
#include "support_terms.h"

uint8_t *container_written(const cvol_array *array, size_t *size)
{
    uint64_t bytes;
    if (cvol_array_write(context, array, file_path, &bytes))
        fail_msg("%s", cvol_context_message(context));
    uint8_t *data = support_read(file_path, size);
    assert_int_equal(*size, bytes);
    return data;
}

uint8_t *container_file_of(const cvol_array *array, size_t *size)
{
    return support_unpack(container_written(array, size), size);
}

cvol_array *container_small_array(void)
{
    return support_terms_make(
        context,
        &(support_terms){.dims = {70, 20, 16}, .block = 16, .split = 1, .lapped = 1, .seed = 3});
}

int container_read_code(const uint8_t *data, size_t size)
{
    cvol_array *array;
    int code = cvol_container_read(context, &array, data, size, "f");
    cvol_array_free(array);
    return code;
}

uint8_t *container_verified(const cvol_array *array, size_t *size)
{
    uint8_t *data = container_written(array, size);
    check_ok(cvol_file_verify(context, NULL, file_path));
    return data;
}

void container_expect_place(size_t at)
{
    const char *message = cvol_context_message(context);
    const char *byte = strstr(message, "byte ");
    unsigned long long told;
    if (strncmp(message, "f: ", 3) || !byte || sscanf(byte, "byte %llu", &told) != 1 || told > at)
        fail_msg("byte %zu: '%s'", at, message);
}
