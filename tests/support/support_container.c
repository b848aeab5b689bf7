#include "test.h"

#include "support_container.h"

#include "base/context.h"
#include "codec/container/container.h"
#include "codec/container/layout.h"
#include "codec/section/section.h"
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

/* The kind of section, or CVOL_SECTION_UNKNOWN. */
static cvol_section_kind kind_of(const char *tag)
{
    cvol_section_kind kind = 0;
    while (kind < CVOL_SECTION_KINDS && strcmp(cvol_section_tag(kind), tag))
        kind++;
    return kind;
}

uint8_t *container_with_section(const uint8_t *data, size_t *size, const char *tag,
                                const void *content, size_t length)
{
    const cvol_section_kind kind = kind_of(tag);
    cvol_file_layout layout;
    cvol_bytes out = {0};
    int i = 0;
    assert_int_not_equal(kind, CVOL_SECTION_UNKNOWN);
    check_ok(cvol_layout_walk(context, &layout, data, *size, "f"));
    while (i < layout.section_count - 1 && kind_of(layout.sections[i].tag) < kind)
        i++;
    const cvol_file_section *next = &layout.sections[i];
    size_t rest = (size_t)next->offset;
    cvol_bytes_append(&out, data, rest);
    if (!strcmp(next->tag, tag))
        rest += CVOL_SECTION_HEADER_BYTES + (size_t)next->length;
    if (content)
        cvol_section_put(&out, kind, &(cvol_bytes){.data = (uint8_t *)content, .size = length});
    cvol_bytes_append(&out, data + rest, *size - rest);
    assert_false(out.failed);
    *size = out.size;
    return out.data;
}

uint8_t *container_with_field(const uint8_t *data, size_t *size, const char *tag, size_t at,
                              const void *bytes, size_t count)
{
    cvol_file_layout layout;
    check_ok(cvol_layout_walk(context, &layout, data, *size, "f"));
    for (int i = 0; i < layout.section_count; i++) {
        const cvol_file_section *section = &layout.sections[i];
        if (strcmp(section->tag, tag))
            continue;
        const size_t length = (size_t)section->length;
        uint8_t *content = malloc(length + 1);
        assert_true(content && at + count <= length);
        memcpy(content, data + section->offset + CVOL_SECTION_HEADER_BYTES, length);
        memcpy(content + at, bytes, count);
        uint8_t *out = container_with_section(data, size, tag, content, length);
        free(content);
        return out;
    }
    fail_msg("there is no section %s", tag);
    return NULL;
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
