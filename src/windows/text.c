/* Text, sorting and locales (posix.h). */
#include <stdatomic.h>

char *cvol_posix_strndup(const char *text, size_t most)
{
    const size_t length = strnlen(text, most);
    char *copy = malloc(length + 1);
    if (copy) {
        memcpy(copy, text, length);
        copy[length] = '\0';
    }
    return copy;
}

void *cvol_posix_memmem(const void *in, size_t size, const void *what, size_t length)
{
    const char *bytes = in;
    for (size_t i = 0; i + length <= size; i++)
        if (!memcmp(bytes + i, what, length))
            return (void *)(uintptr_t)(bytes + i);
    return NULL;
}

void *cvol_posix_memrchr(const void *in, int byte, size_t size)
{
    const unsigned char *bytes = in;
    while (size)
        if (bytes[--size] == (unsigned char)byte)
            return (void *)(uintptr_t)(bytes + size);
    return NULL;
}

static int is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* Bytes, but numbers by their value; a number with leading zeros is a fraction, before all others
 * that begin with the same digits, as the C library of GNU has it. */
int cvol_posix_strverscmp(const char *a, const char *b)
{
    size_t i = 0, start;
    while (a[i] && a[i] == b[i])
        i++;
    for (start = i; start && is_digit(a[start - 1]);)
        start--;
    const int difference = (unsigned char)a[i] - (unsigned char)b[i];
    if (!(is_digit(a[i]) || start < i) || !(is_digit(b[i]) || start < i))
        return difference;
    const size_t m = strspn(a + start, "0123456789"), n = strspn(b + start, "0123456789");
    const int is_fraction = (a[start] == '0' && start + 1 < i + (size_t)is_digit(a[i])) ||
                            (b[start] == '0' && start + 1 < i + (size_t)is_digit(b[i]));
    return is_fraction || m == n ? difference : m < n ? -1 : 1;
}

ssize_t cvol_posix_getline(char **text, size_t *bytes, FILE *file)
{
    size_t length = 0;
    for (int c = 0; c != '\n' && (c = getc(file)) != EOF;) {
        if (length + 2 > *bytes) {
            const size_t room = 2 * length + 128;
            char *more = realloc(*text, room);
            if (!more)
                return -1;
            *text = more;
            *bytes = room;
        }
        (*text)[length++] = (char)c;
    }
    if (!length)
        return -1;
    (*text)[length] = '\0';
    return (ssize_t)length;
}

/* Sorts by merging, as the C library of GNU does: equal items keep their order. */
static void merge_sort(char *items, char *spare, size_t count, size_t size,
                       int (*compare)(const void *, const void *, void *), void *user)
{
    const size_t half = count / 2;
    if (!half)
        return;
    merge_sort(items, spare, half, size, compare, user);
    merge_sort(items + half * size, spare, count - half, size, compare, user);
    memcpy(spare, items, half * size);
    for (size_t i = 0, j = half, k = 0; i < half; k++) {
        const int takes_later = j < count && compare(spare + i * size, items + j * size, user) > 0;
        memcpy(items + k * size, takes_later ? items + j * size : spare + i * size, size);
        i += (size_t)!takes_later;
        j += (size_t)takes_later;
    }
}

static void insertion_sort(char *items, size_t count, size_t size,
                           int (*compare)(const void *, const void *, void *), void *user)
{
    for (size_t i = 1; i < count; i++)
        for (char *at = items + i * size; at > items && compare(at - size, at, user) > 0;
             at -= size)
            for (size_t k = 0; k < size; k++) {
                const char byte = at[k];
                at[k] = (at - size)[k];
                (at - size)[k] = byte;
            }
}

void cvol_posix_qsort_r(void *items, size_t count, size_t size,
                        int (*compare)(const void *, const void *, void *), void *user)
{
    char *spare = count / 2 ? malloc(count / 2 * size) : NULL;
    if (spare)
        merge_sort(items, spare, count, size, compare, user);
    else
        insertion_sort(items, count, size, compare, user);
    free(spare);
}

struct cvol_posix_locale {
    int was_of_thread;
    char name[256]; /* "": a new one, C */
};

locale_t cvol_posix_newlocale(int mask, const char *name, locale_t base)
{
    (void)mask, (void)name, (void)base;
    return calloc(1, sizeof(struct cvol_posix_locale));
}

locale_t cvol_posix_uselocale(locale_t locale)
{
    static _Thread_local struct cvol_posix_locale before;
    if (locale == &before) {
        setlocale(LC_ALL, before.name);
        _configthreadlocale(before.was_of_thread);
        return NULL;
    }
    before.was_of_thread = _configthreadlocale(_ENABLE_PER_THREAD_LOCALE);
    snprintf(before.name, sizeof before.name, "%s", setlocale(LC_ALL, NULL));
    setlocale(LC_ALL, "C");
    return &before;
}

void cvol_posix_freelocale(locale_t locale)
{
    free(locale);
}
