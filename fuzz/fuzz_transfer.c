/* Fuzzing of the transfer function reader: any bytes must give points or an error with a message.
 */
#include "fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char name[64];
    if (!fuzz_write_file(name, data, size))
        return 0;
    cvol_context *context = fuzz_context();
    cvol_transfer *transfer = NULL;
    int code = cvol_transfer_read(context, &transfer, name);
    if (code ? !cvol_context_message(context)[0] : !cvol_transfer_count(transfer))
        abort();
    cvol_transfer_free(transfer);
    cvol_context_free(context);
    return 0;
}
