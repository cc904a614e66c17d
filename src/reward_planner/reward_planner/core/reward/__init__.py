"""The paper's rule: steps by rewards and penalties, with a virtual search where they do not decide."""
