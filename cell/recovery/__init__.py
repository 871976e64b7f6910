"""What the cell does about faults: the policy, who is to blame, and the check before going on."""
