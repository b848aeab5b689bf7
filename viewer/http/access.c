/* Authorization of requests. */
#include "viewer/http/access.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

int access_rules_make(access_rules *rules, const viewer_options *options)
{
    uint8_t random[TOKEN_LETTERS / 2];
    FILE *source = fopen("/dev/urandom", "rb");
    const size_t got = source ? fread(random, 1, sizeof random, source) : 0;
    if (source)
        fclose(source);
    if (got != sizeof random)
        return -1;
    for (size_t i = 0; i < sizeof random; i++)
        snprintf(rules->token + 2 * i, 3, "%02x", random[i]);
    rules->host_count = 0;
    rules->hosts[rules->host_count++] = "localhost";
    rules->hosts[rules->host_count++] = "127.0.0.1";
    rules->hosts[rules->host_count++] = "::1";
    if (options->listen)
        rules->hosts[rules->host_count++] = options->listen;
    for (int i = 0; i < options->host_count; i++)
        rules->hosts[rules->host_count++] = options->hosts[i];
    return 0;
}

/* Finds the name in "NAME", "NAME:PORT" or "[ADDRESS]:PORT"; its length, or 0. */
static size_t find_name(const char **name, const char *host)
{
    const char *end;
    if (*host == '[') {
        *name = host + 1;
        end = strchr(host, ']');
        if (!end || (end[1] && end[1] != ':'))
            return 0;
        host = end + 1;
    } else {
        *name = host;
        end = host + strcspn(host, ":");
        host = end;
    }
    if (*host == ':' && (!host[1] || host[1 + strspn(host + 1, "0123456789")]))
        return 0;
    return (size_t)(end - *name);
}

static int is_ours(const access_rules *rules, const char *host)
{
    const char *name;
    const size_t length = find_name(&name, host);
    for (int i = 0; i < rules->host_count; i++)
        if (length && strlen(rules->hosts[i]) == length &&
            !strncasecmp(rules->hosts[i], name, length))
            return 1;
    return 0;
}

/* 1 if the origin is the host of the request, including the port: other ports are other programs.
 */
static int is_same(const char *origin, const char *host)
{
    const char *schemes[] = {"http://", "https://"};
    for (int i = 0; i < 2; i++)
        if (!strncasecmp(origin, schemes[i], strlen(schemes[i])))
            return !strcasecmp(origin + strlen(schemes[i]), host);
    return 0;
}

/* Compares in constant time. */
static int is_token(const access_rules *rules, const char *text)
{
    unsigned difference = 0;
    int i = 0;
    for (; i < TOKEN_LETTERS && text[i]; i++)
        difference |= (unsigned)(text[i] ^ rules->token[i]);
    return i == TOKEN_LETTERS && !difference;
}

const char *access_rules_check(const access_rules *rules, answer *refusal, const char *path,
                               const char *host, const char *origin, const char *site)
{
    if (!host || !is_ours(rules, host))
        *refusal = answer_error(
            403,
            "Host is '%.100s', which is not a name of this server: start it with "
            "--host NAME to allow it",
            host ? host : "");
    else if (origin && !is_same(origin, host))
        *refusal = answer_error(403, "Origin is '%.100s', which is another site", origin);
    else if (site && !strcasecmp(site, "cross-site"))
        *refusal = answer_error(403, "the request comes from another site");
    else if (path[0] != '/' || !is_token(rules, path + 1))
        *refusal = answer_error(
            403, "the token is missing or wrong: open the URL that cvol view printed");
    else if (path[1 + TOKEN_LETTERS] != '/')
        *refusal = answer_error(404, "a slash is missing after the token in the URL");
    else
        return path + 1 + TOKEN_LETTERS + 1;
    return NULL;
}
