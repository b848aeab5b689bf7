/* The part of XML that headers need: elements in order, and their attributes. */
#ifndef CVOL_VOLUME_IO_XML_H
#define CVOL_VOLUME_IO_XML_H

#include <stddef.h>

/* An element's opening or closing tag within a text that ends with a NUL. */
typedef struct cvol_xml_tag {
    const char *name; /* without '<' or "</" */
    size_t name_length;
    const char *attributes, *end; /* the tag's '>'; the text after it begins at end + 1 */
    int closes;                   /* "</name>" */
    int is_empty;                 /* "<name/>" */
} cvol_xml_tag;

/* The next tag from `text` on, without comments and declarations; 0 if there is none. */
int cvol_xml_next(cvol_xml_tag *tag, const char *text);
int cvol_xml_is(const cvol_xml_tag *tag, const char *name);
/* An attribute's value and its length, or NULL. */
const char *cvol_xml_attribute(const cvol_xml_tag *tag, const char *name, size_t *length);

#endif
