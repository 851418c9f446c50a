struct VolumePush {
    uint scan_plane; // 1: the paper's interval
    uint integral;   // INTEGRAL_CLOSED and so on
    uint padding0;
    uint padding1;
};
