/* Names and colours of labels in extensions of NIfTI files:
 *
 *     AFNI (code 4):       an attribute VALUE_LABEL_DTABLE of pairs "3" "name", in XML in XML
 *     Workbench (code 30): <Label Key="3" Red="1" Green="0" Blue="0" Alpha="1">name</Label>
 */
#include <stdlib.h>
#include <string.h>

#include "base/byte_order.h"
#include "base/context.h"
#include "volume/formats/label_list.h"
#include "volume/formats/nifti_fields.h"
#include "volume/io/packed.h"
#include "volume/io/text.h"
#include "volume/io/xml.h"

enum { AFNI = 4, WORKBENCH = 30 };
/* Extensions are read up to this size. */
#define EXTENSIONS_MOST ((uint64_t)64 << 20)

/* ---- text ---------------------------------------------------------------------------- */

/* Replaces the five entities of XML, in place. */
static void decode_entities(char *text)
{
    static const struct {
        const char *name;
        char letter;
    } entities[] = {
        {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}, {"&amp;", '&'}};
    char *to = text;
    while (*text) {
        size_t e = 0;
        while (e < 5 && strncmp(text, entities[e].name, strlen(entities[e].name)))
            e++;
        *to++ = e < 5 ? entities[e].letter : *text;
        text += e < 5 ? strlen(entities[e].name) : 1;
    }
    *to = '\0';
}

/* The next text in quotes; NULL: there is none. *text moves behind it. */
static char *take_quoted(char **text, size_t *length)
{
    char *begin = strchr(*text, '"'), *end = begin ? strchr(begin + 1, '"') : NULL;
    if (!end)
        return NULL;
    *length = (size_t)(end - begin - 1);
    *text = end + 1;
    return begin + 1;
}

static int take_value(int *out, const char *text, size_t length)
{
    int64_t value;
    if (!cvol_text_integer(text, length, &value) || value < INT32_MIN || value > INT32_MAX)
        return 0;
    *out = (int)value;
    return 1;
}

/* ---- AFNI ---------------------------------------------------------------------------- */

static int list_afni(cvol_context *context, cvol_label_list *list, char *text, const char *path)
{
    char *at = strstr(text, "atr_name=\"VALUE_LABEL_DTABLE\""),
         *end = at ? strstr(at, "</AFNI_atr>") : NULL;
    if (!end)
        return CVOL_OK;
    *end = '\0';
    decode_entities(at);
    at = strstr(at, "<VALUE_LABEL_DTABLE");
    at = at ? strchr(at, '>') : NULL;
    if (at && (end = strstr(at, "</VALUE_LABEL_DTABLE")))
        *end = '\0';
    int code = CVOL_OK;
    while (at && !code) {
        size_t key_length, length;
        int value;
        const char *key = take_quoted(&at, &key_length);
        char *name = key ? take_quoted(&at, &length) : NULL;
        if (!name || !take_value(&value, key, key_length))
            break;
        name[length] = '\0';
        decode_entities(name); /* the table is XML as well */
        length = strlen(name);
        code = cvol_label_list_add(context, list, value, name, length, NULL, path);
    }
    return code;
}

/* ---- Workbench ----------------------------------------------------------------------- */

static int take_colour(double rgb[3], const cvol_xml_tag *tag)
{
    static const char *const names[] = {"Red", "Green", "Blue"};
    for (int c = 0; c < 3; c++) {
        size_t length;
        const char *text = cvol_xml_attribute(tag, names[c], &length);
        if (!text || !cvol_text_number(text, length, &rgb[c]) || !(rgb[c] >= 0 && rgb[c] <= 1))
            return 0;
    }
    return 1;
}

/* The text up to the closing tag, without the marks of CDATA; changes it. */
static char *name_of(char *text, size_t *length)
{
    static const char before[] = "<![CDATA[";
    const int is_raw = !strncmp(text, before, sizeof before - 1);
    char *begin = is_raw ? text + sizeof before - 1 : text,
         *end = strstr(begin, is_raw ? "]]>" : "</Label>");
    if (!end)
        return NULL;
    *length = (size_t)(end - begin);
    char *name = malloc(*length + 1);
    if (!name)
        return NULL;
    memcpy(name, begin, *length);
    name[*length] = '\0';
    if (!is_raw)
        decode_entities(name);
    *length = strlen(name);
    return name;
}

static int list_workbench(cvol_context *context, cvol_label_list *list, char *text,
                          const char *path)
{
    cvol_xml_tag tag;
    int code = CVOL_OK, has_begun = 0;
    while (!code && cvol_xml_next(&tag, text)) {
        text += tag.end + 1 - text;
        if (cvol_xml_is(&tag, "LabelTable") && tag.closes)
            break; /* further tables are those of further volumes */
        has_begun = has_begun || cvol_xml_is(&tag, "LabelTable");
        if (!has_begun || !cvol_xml_is(&tag, "Label") || tag.closes)
            continue;
        size_t length;
        int value;
        double rgb[3];
        const char *key = cvol_xml_attribute(&tag, "Key", &length);
        if (!key || !take_value(&value, key, length))
            break;
        const int has_colour = take_colour(rgb, &tag);
        if (tag.is_empty) {
            code = cvol_label_list_add(context, list, value, "", 0, has_colour ? rgb : NULL, path);
            continue;
        }
        char *name = name_of(text, &length);
        if (!name) /* without its end, or no memory */
            break;
        code = cvol_label_list_add(context, list, value, name, length, has_colour ? rgb : NULL,
                                   path);
        free(name);
    }
    return code;
}

/* ---- extensions ---------------------------------------------------------------------- */

static uint32_t get_word(const uint8_t *p, int big_endian)
{
    const uint32_t high = cvol_high_first(p);
    return big_endian ? high : __builtin_bswap32(high);
}

/* Walks the extensions: their size, a multiple of 16 from 16 on, their code, and content. */
static int list_extensions(cvol_context *context, cvol_label_list *list, const uint8_t *bytes,
                           size_t size, int big_endian, const char *path)
{
    int code = CVOL_OK;
    while (!code && size >= 8 && !list->count) {
        const uint32_t length = get_word(bytes, big_endian), kind = get_word(bytes + 4, big_endian);
        if (length < 8 || length > size)
            break;
        char *text = kind == AFNI || kind == WORKBENCH ? malloc(length - 8 + 1) : NULL;
        if (!text && (kind == AFNI || kind == WORKBENCH))
            return cvol_fail_memory(context, length, path);
        if (text) {
            memcpy(text, bytes + 8, length - 8);
            text[length - 8] = '\0';
            code = kind == AFNI ? list_afni(context, list, text, path)
                                : list_workbench(context, list, text, path);
        }
        free(text);
        bytes += length;
        size -= length;
    }
    return code;
}

static int read_extensions(cvol_context *context, cvol_label_list *list, cvol_packed *file,
                           const char *path)
{
    cvol_nifti_header header = {0};
    uint8_t flag[4];
    uint64_t got = 0;
    int code = cvol_packed_read(context, file, header.bytes, 348, &got);
    if (code || !cvol_nifti_find_layout(&header, (size_t)got))
        return code;
    const cvol_nifti_layout *at = header.at;
    if (at->size > got)
        code = cvol_packed_read(context, file, header.bytes + got, at->size - got, &got);
    if (!code && !memcmp(header.bytes + at->magic_at, at->magic, 4))
        code = cvol_packed_read(context, file, flag, sizeof flag, &got);
    else
        return code; /* pairs have their extensions in the header: none are known with labels */
    if (code || got < sizeof flag || !flag[0])
        return code;
    const double offset = at->version == 1
                              ? cvol_nifti_get_real(&header, at->vox_offset, 0)
                              : (double)cvol_nifti_get_integer(&header, at->vox_offset, 8);
    const double size = offset - (double)at->size - 4;
    if (!(size >= 16) || size > (double)EXTENSIONS_MOST)
        return CVOL_OK;
    uint8_t *bytes = malloc((size_t)size);
    if (!bytes)
        return cvol_fail_memory(context, (size_t)size, path);
    code = cvol_packed_read(context, file, bytes, (uint64_t)size, &got);
    if (!code)
        code = list_extensions(context, list, bytes, (size_t)got, header.big_endian, path);
    free(bytes);
    return code;
}

int cvol_nifti_list_labels(cvol_context *context, cvol_label_list *list, const char *path)
{
    cvol_packed file;
    int code = cvol_packed_open(context, &file, path);
    if (!code)
        code = read_extensions(context, list, &file, path);
    cvol_packed_close(&file);
    return code;
}
