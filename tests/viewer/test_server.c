/* Connections of the viewer: large answers to slow clients. */
#include "test.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "viewer/http/server.h"

enum { LARGE = 48 << 20, READ = 512 << 10 };

static const server_limits limits = {
    .unknown_ms = 60e3, .receiving_ms = 60e3, .sending_ms = 1000, .step_bytes = 64 << 10};

static char *bytes; /* [LARGE] */

static answer give_bytes(request *r)
{
    (void)r;
    return answer_bytes("text/plain", bytes, LARGE, NULL);
}

static answer give_file(request *r)
{
    (void)r;
    char name[] = "/tmp/cvol-server-XXXXXX";
    const int fd = mkstemp(name);
    assert_true(fd > 0);
    unlink(name);
    for (size_t done = 0; done < LARGE;) {
        const ssize_t written = write(fd, bytes + done, LARGE - done);
        assert_true(written > 0);
        done += (size_t)written;
    }
    return (answer){.status = 200, .type = "text/plain", .size = LARGE, .fd = fd};
}

static const route_entry routes[] = {{"GET", "bytes", give_bytes}, {"GET", "file", give_file}};

static const viewer_options options = {.threads = 1};
static service served = {
    .options = &options, .own = routes, .own_count = sizeof routes / sizeof *routes};
static access_rules rules;
static server *tested;

static int setup(void **state)
{
    (void)state;
    char message[256];
    bytes = malloc(LARGE);
    for (size_t i = 0; bytes && i < LARGE; i++)
        bytes[i] = (char)('a' + i / 7 % 26);
    if (!bytes || access_rules_make(&rules, &options))
        return -1;
    tested = server_open(message, sizeof message, &served, &rules);
    if (tested)
        server_set_limits(tested, &limits);
    return tested ? 0 : -1;
}

static int teardown(void **state)
{
    (void)state;
    server_close(tested);
    free(bytes);
    return 0;
}

/* Sends a request on a connection with a small buffer. */
static int ask(const char *path)
{
    char text[256];
    const int s = socket(AF_INET, SOCK_STREAM, 0), small = 64 << 10;
    struct sockaddr_in address = {.sin_family = AF_INET,
                                  .sin_port = htons((uint16_t)server_port(tested)),
                                  .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    assert_int_equal(setsockopt(s, SOL_SOCKET, SO_RCVBUF, &small, sizeof small), 0);
    assert_int_equal(connect(s, (struct sockaddr *)&address, sizeof address), 0);
    const int length = snprintf(text, sizeof text, "GET /%s/%s HTTP/1.1\r\nHost: localhost\r\n\r\n",
                                rules.token, path);
    assert_int_equal(send(s, text, (size_t)length, 0), length);
    return s;
}

static void pause_ms(long ms)
{
    const struct timespec t = {ms / 1000, ms % 1000 * 1000000};
    nanosleep(&t, NULL);
}

/* Receives an answer, for twice as long as a small one may take at most `most` bytes each 20
 * ms; the size of its content, of which each byte is checked. */
static size_t receive(const char *path, size_t most)
{
    static char part[READ];
    const int s = ask(path);
    const double end = jobs_now() + 2 * limits.sending_ms;
    size_t content = 0;
    int in_head = 4; /* characters of the empty line that are still to come */
    for (;;) {
        const ssize_t got = recv(s, part, jobs_now() < end ? most : READ, 0);
        if (got <= 0)
            break;
        for (ssize_t i = 0; i < got; i++) {
            if (in_head)
                in_head = part[i] == "\n\r\n\r"[in_head - 1] ? in_head - 1
                          : part[i] == '\r'                  ? 3
                                                             : 4;
            else if (part[i] != bytes[content++])
                fail_msg("byte %zu is wrong", content - 1);
        }
        if (content == LARGE)
            break;
        server_sweep(tested);
        if (jobs_now() < end)
            pause_ms(20);
    }
    close(s);
    return content;
}

/* Each takes longer than a small answer may take. */
static void test_large_answers(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        const double begin = jobs_now();
        assert_int_equal(receive(i ? "file" : "bytes", READ), LARGE);
        assert_true(jobs_now() - begin > 1.5 * limits.sending_ms);
    }
}

/* It receives something all the time, but not enough: the rest of what the server has sent is in
 * the buffers of the connection. */
static void test_a_client_that_is_too_slow(void **state)
{
    (void)state;
    const size_t received = receive("bytes", 8);
    assert_true(received > 0 && received < LARGE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_large_answers),
                                       cmocka_unit_test(test_a_client_that_is_too_slow)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
