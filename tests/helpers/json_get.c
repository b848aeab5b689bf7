/* json_get KEY [KIND]: reads standard input, which must be one JSON object and nothing else, and
 * prints the value at KEY. KEY is names and indices with dots between them: "frame_ms.all.0". KIND
 * is the required kind of the value: number, integer, string, boolean, array, object, null or
 * decibels (a number or null). Strings are printed bare, arrays and objects on one line. Fails with
 * a message otherwise. */
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

static json_t *step_into(json_t *value, const char *name, size_t length)
{
    char text[128];
    if (length >= sizeof text)
        return NULL;
    memcpy(text, name, length);
    text[length] = '\0';
    if (json_is_array(value))
        return json_array_get(value, strtoul(text, NULL, 10));
    return json_object_get(value, text);
}

static json_t *find(json_t *value, const char *key)
{
    while (value && *key) {
        size_t length = strcspn(key, ".");
        value = step_into(value, key, length);
        key += length + (key[length] == '.');
    }
    return value;
}

static int is_of_kind(const json_t *value, const char *kind)
{
    return (!strcmp(kind, "number") && json_is_number(value)) ||
           (!strcmp(kind, "integer") && json_is_integer(value)) ||
           (!strcmp(kind, "string") && json_is_string(value)) ||
           (!strcmp(kind, "boolean") && json_is_boolean(value)) ||
           (!strcmp(kind, "null") && json_is_null(value)) ||
           (!strcmp(kind, "decibels") && (json_is_number(value) || json_is_null(value))) ||
           (!strcmp(kind, "array") && json_is_array(value)) ||
           (!strcmp(kind, "object") && json_is_object(value));
}

static void print(const json_t *value)
{
    if (json_is_string(value))
        fputs(json_string_value(value), stdout);
    else
        json_dumpf(value, stdout, JSON_ENCODE_ANY | JSON_COMPACT | JSON_REAL_PRECISION(12));
    putchar('\n');
}

int main(int argc, char **argv)
{
    json_error_t error;
    if (argc < 2 || argc > 3) {
        fputs("usage: json_get KEY [KIND]\n", stderr);
        return 2;
    }
    int found = 0;
    json_t *root = json_loadf(stdin, JSON_REJECT_DUPLICATES, &error);
    json_t *value = find(root, argv[1]);
    if (!root)
        fprintf(stderr, "json_get: line %d: %s\n", error.line, error.text);
    else if (!json_is_object(root))
        fputs("json_get: not an object\n", stderr);
    else if (!value)
        fprintf(stderr, "json_get: there is no %s\n", argv[1]);
    else if (argc == 3 && !is_of_kind(value, argv[2]))
        fprintf(stderr, "json_get: %s is no %s\n", argv[1], argv[2]);
    else {
        print(value);
        found = 1;
    }
    json_decref(root);
    return !found;
}
