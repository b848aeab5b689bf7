/* Patterns of file names (glob.h). */
#include <glob.h>

/* 1 if the character is in the set after '[', or not in it after "[!". *end: behind its ']'; NULL:
 * the set has no end. */
static int is_in_set(char c, const char *set, const char **end)
{
    const int excludes = *set == '!' || *set == '^';
    int found = 0;
    const char *s = set + excludes;
    do {
        const int is_range = s[0] && s[1] == '-' && s[2] && s[2] != ']';
        found |= is_range ? c >= s[0] && c <= s[2] : c == s[0];
        s += is_range ? 3 : 1;
    } while (*s && *s != ']');
    *end = *s ? s + 1 : NULL;
    return found != excludes;
}

static int matches(const char *name, const char *pattern)
{
    for (; *pattern; name++) {
        const char *end = NULL;
        if (*pattern == '*') {
            for (; *name && !matches(name, pattern + 1); name++)
                ;
            return *name || matches(name, pattern + 1);
        }
        if (!*name)
            return 0;
        if (*pattern == '[' && is_in_set(*name, pattern + 1, &end))
            pattern = end ? end : pattern + 1;
        else if (!end && (*pattern == '?' || *pattern == *name))
            pattern++;
        else
            return 0;
    }
    return !*name;
}

static int add(glob_t *found, const char *folder, const char *name)
{
    char **paths = realloc(found->gl_pathv, (found->gl_pathc + 1) * sizeof *paths);
    if (!paths)
        return GLOB_NOSPACE;
    found->gl_pathv = paths;
    if (asprintf(&paths[found->gl_pathc], "%s%s", folder, name) < 0)
        return GLOB_NOSPACE;
    found->gl_pathc++;
    return 0;
}

int cvol_posix_glob(const char *pattern, int flags, void *handler, glob_t *found)
{
    (void)flags, (void)handler;
    *found = (glob_t){0, NULL};
    const char *slash = strrchr(pattern, '/'), *last = slash ? slash + 1 : pattern;
    char *folder = strndup(pattern, (size_t)(last - pattern));
    DIR *directory = folder ? opendir(*folder ? folder : ".") : NULL;
    int result = !folder ? GLOB_NOSPACE : directory ? 0 : GLOB_NOMATCH;
    for (const struct dirent *entry; !result && (entry = readdir(directory));)
        if ((entry->d_name[0] != '.' || *last == '.') && matches(entry->d_name, last))
            result = add(found, folder, entry->d_name);
    if (directory)
        closedir(directory);
    free(folder);
    if (result)
        globfree(found);
    return !result && !found->gl_pathc ? GLOB_NOMATCH : result;
}

void cvol_posix_globfree(glob_t *found)
{
    for (size_t i = 0; i < found->gl_pathc; i++)
        free(found->gl_pathv[i]);
    free(found->gl_pathv);
    *found = (glob_t){0, NULL};
}
