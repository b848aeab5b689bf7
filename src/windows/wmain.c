/* The command's start: arguments in UTF-8, and a terminal that shows it. */
#include "windows/wide.h"

#define WIN32_LEAN_AND_MEAN
#include <windows.h>

int main(int argc, char **argv);
int wmain(int argc, wchar_t **wide);

/* An argument whose part before its last '\' is a folder is a path: it gets '/', as cvol expects.
 */
static void use_slashes(char *argument)
{
    char *last = strrchr(argument, '\\');
    struct stat status;
    if (!last)
        return;
    *last = '\0';
    const int is_path = last == argument || last[-1] == ':' ||
                        (!stat(argument, &status) && S_ISDIR(status.st_mode));
    *last = '\\';
    for (char *c = argument; is_path && *c; c++)
        if (*c == '\\')
            *c = '/';
}

static void prepare_terminal(void)
{
    const HANDLE terminal = GetStdHandle(STD_ERROR_HANDLE);
    DWORD mode;
    SetConsoleOutputCP(CP_UTF8);
    if (GetConsoleMode(terminal, &mode)) /* sequences that clear a line */
        SetConsoleMode(terminal, mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING);
    for (int fd = 0; fd < 3; fd++)
        _setmode(fd, _O_BINARY);
}

int wmain(int argc, wchar_t **wide)
{
    char **argv = calloc((size_t)argc + 1, sizeof *argv);
    for (int i = 0; argv && i < argc; i++) {
        argv[i] = cvol_narrow(wide[i]);
        if (!argv[i])
            return 1;
        use_slashes(argv[i]);
    }
    prepare_terminal();
    return argv ? main(argc, argv) : 1;
}
