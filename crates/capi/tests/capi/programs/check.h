/* What the test programs share: a check that says where it failed, and files read whole. */
#ifndef CHECK_H
#define CHECK_H
#include <rhytid.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(what)                                                                                    \
    do {                                                                                               \
        if (!(what)) {                                                                                 \
            fprintf(stderr, "%s:%d: not so: %s; last error: %s\n", __FILE__, __LINE__, #what,          \
                    rhytid_last_error());                                                              \
            exit(1);                                                                                   \
        }                                                                                              \
    } while (0)

/* The call fails with this status, and its sentence has this word. */
#define FAILS(status, word, call)                                                                      \
    do {                                                                                               \
        CHECK((call) == (status));                                                                     \
        CHECK(strstr(rhytid_last_error(), word) != NULL);                                              \
    } while (0)

#define OK(call) CHECK((call) == RHYTID_STATUS_OK)

static inline unsigned char *contents(const char *path, size_t *length) {
    FILE *file = fopen(path, "rb");
    CHECK(file && fseek(file, 0, SEEK_END) == 0);
    long size = ftell(file);
    CHECK(size > 0 && fseek(file, 0, SEEK_SET) == 0);
    unsigned char *bytes = (unsigned char *)malloc((size_t)size);
    CHECK(bytes && fread(bytes, 1, (size_t)size, file) == (size_t)size);
    fclose(file);
    *length = (size_t)size;
    return bytes;
}

#endif
