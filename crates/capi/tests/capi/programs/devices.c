/* The devices of this machine: each is named, and each backend without one is said. */
#include "check.h"

int main(void) {
    RhytidDevices *devices;
    OK(rhytid_devices_find(&devices));
    size_t count = rhytid_devices_count(devices);
    int found = 0;
    for (size_t i = 0; i < count; i++) {
        CHECK(strlen(rhytid_devices_name(devices, i)) > 0 && strlen(rhytid_devices_driver(devices, i)) > 0);
        if (strcmp(rhytid_devices_id(devices, i), "cpu:0") == 0) {
            CHECK(rhytid_devices_kind(devices, i) == RHYTID_DEVICE_KIND_CPU);
            CHECK(rhytid_devices_memory(devices, i) > 0);
            found++;
        }
    }
    CHECK(found == 1 && rhytid_devices_id(devices, count) == NULL);
    for (size_t i = 0; i < rhytid_devices_missing_count(devices); i++) {
        CHECK(strstr(rhytid_devices_missing(devices, i), ": ") != NULL);
    }
    CHECK(rhytid_devices_missing(devices, rhytid_devices_missing_count(devices)) == NULL);
    rhytid_devices_free(devices);
    puts("the devices are listed");
    return 0;
}
