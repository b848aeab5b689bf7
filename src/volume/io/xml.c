/* The part of XML that headers need. Entities stay unchanged. */
#include "volume/io/xml.h"

#include <string.h>

static int is_blank(char c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

/* The end of a comment or a declaration that begins at `text`; NULL if it does not end. */
static const char *pass_over(const char *text)
{
    const char *end = !strncmp(text, "<!--", 4) ? strstr(text, "-->") : strchr(text, '>');
    return end ? end + (*end == '-' ? 3 : 1) : NULL;
}

int cvol_xml_next(cvol_xml_tag *tag, const char *text)
{
    while ((text = strchr(text, '<')) && (text[1] == '!' || text[1] == '?'))
        if (!(text = pass_over(text)))
            return 0;
    if (!text)
        return 0;
    *tag = (cvol_xml_tag){.closes = text[1] == '/'};
    tag->name = text + 1 + tag->closes;
    tag->name_length = strcspn(tag->name, " \t\r\n/>");
    tag->attributes = tag->name + tag->name_length;
    /* A '>' in quotes does not end a tag. */
    char quote = '\0';
    const char *at = tag->attributes;
    for (; *at && (quote || *at != '>'); at++)
        if (quote ? *at == quote : *at == '"' || *at == '\'')
            quote = quote ? '\0' : *at;
    tag->end = at;
    tag->is_empty = at > tag->attributes && at[-1] == '/';
    return *at == '>';
}

int cvol_xml_is(const cvol_xml_tag *tag, const char *name)
{
    return strlen(name) == tag->name_length && !memcmp(tag->name, name, tag->name_length);
}

const char *cvol_xml_attribute(const cvol_xml_tag *tag, const char *name, size_t *length)
{
    const char *at = tag->attributes;
    while (at < tag->end) {
        while (at < tag->end && is_blank(*at))
            at++;
        const char *key = at;
        while (at < tag->end && *at != '=' && !is_blank(*at))
            at++;
        const size_t key_length = (size_t)(at - key);
        while (at < tag->end && (*at == '=' || is_blank(*at)))
            at++;
        const char quote = *at;
        if (at >= tag->end || (quote != '"' && quote != '\''))
            return NULL;
        const char *value = ++at;
        while (at < tag->end && *at != quote)
            at++;
        if (key_length == strlen(name) && !memcmp(key, name, key_length)) {
            *length = (size_t)(at - value);
            return value;
        }
        at++;
    }
    return NULL;
}
