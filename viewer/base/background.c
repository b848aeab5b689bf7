/* Work in the background. */
#include "viewer/base/background.h"

#include <pthread.h>

int run_in_background(void *(*run)(void *), void *argument)
{
    pthread_t thread;
    if (pthread_create(&thread, NULL, run, argument))
        return -1;
    pthread_detach(thread);
    return 0;
}
